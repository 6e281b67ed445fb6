//! A rendered receiver beside its exact picture, the signed error, and the error in standard errors.

use super::axis::Axis;
use super::ink::{Align, Page};
use super::raster::{Frame, Scale};
use super::style::{Colour, Dash, GREY, INK, SMALL, TEXT, TITLE, shown};
use crate::configuration::ReceiverShape;
use crate::oracle::Region;
use crate::report::image::{Tone, quantile};
use crate::statistics::Verdict;
use crate::trial::{Judged, ReceiverPicture};

/// Where the umbra ends, and where the penumbra does.
pub const UMBRA: Colour = Colour(0xe6, 0x9f, 0x00);
pub const PENUMBRA: Colour = Colour(0x56, 0xb4, 0xe9);
/// Errors are shown up to what all but one in two hundred stay below.
const SHOWN: f64 = 0.995;
/// z beyond this is as dark as it gets.
const LARGEST_Z: f64 = 5.0;

/// The page, points.
const WIDTH: f64 = 900.0;
const MARGIN: f64 = 24.0;

/// The whole page; one panel where no exact picture is known.
pub fn receiver(receiver: &ReceiverPicture) -> Page {
    let [columns, rows] = receiver.view.pixels();
    let is_known = receiver.due.iter().any(Option::is_some);
    let [across, up] = receiver.view.extent();
    let slot = 0.5 * (WIDTH - 2.0 * MARGIN);
    let room = if is_known { (slot - 62.0 - 84.0, 330.0) } else { (WIDTH - 2.0 * MARGIN - 62.0 - 84.0, 560.0) };
    let shape = across / up;
    let probe = Frame::fitted((0.0, 0.0), room, shape);
    let step = probe.height + 90.0;
    let height = 84.0 + if is_known { 2.0 * step } else { step } + 34.0;
    let mut page = Page::new(WIDTH, height);
    page.bold((MARGIN, 24.0), receiver.title.as_str(), TITLE, INK, Align::Start);
    let mut words = format!(
        "{}: {} points, {} on each source for each pixel",
        receiver.case,
        shown(receiver.settings.strategy),
        receiver.settings.samples
    );
    if let Some(light) = &receiver.light {
        words +=
            &format!("; {} rays from the light, {} × {} texels", grouped(light.rays), light.map[0], light.map[1]);
    }
    page.text((MARGIN, 46.0), words, TEXT, GREY, Align::Start);

    let irradiance = |x: usize, y: usize| receiver.picture.pixel(x, y).lit.map(|lit| lit.irradiance());
    let due = |x: usize, y: usize| receiver.due_around(x, y).map(|(_, due)| due.irradiance);
    let error = |x: usize, y: usize| receiver.error_around(x, y);
    let z = |x: usize, y: usize| receiver.z_around(x, y);
    let places = || (0..columns * rows).map(|k| (k % columns, k / columns));
    let tone = Scale::Tone(Tone::of(places().filter_map(|(x, y)| irradiance(x, y))));
    let errors = places().filter_map(|(x, y)| error(x, y)).map(f64::abs).filter(|error| *error > 0.0);
    let largest = quantile(errors, SHOWN);
    let signed = Scale::Signed { largest: largest.unwrap_or(1.0) };
    let of_z = Scale::Signed { largest: LARGEST_Z };
    type Values<'a> = &'a dyn Fn(usize, usize) -> Option<f64>;
    let mut panels: Vec<(&str, &str, &str, Values, Scale)> =
        vec![("rendered", "irradiance at the middle of each pixel", "W/m²", &irradiance, tone)];
    if is_known {
        panels.push(("exact", "what is due there", "W/m²", &due, tone));
        panels.push(("rendered less exact", "orange: too bright; blue: too dark", "W/m²", &error, signed));
        panels.push(("z", "the same over its standard error; grey: none", "", &z, of_z));
    }
    let names = axis_names(receiver.view.shape());
    let axes = [Axis::linear(0.0, across, false, 4), Axis::linear(0.0, up, false, 4)];
    let mut has_regions = false;
    for (k, (heading, below, unit, values, scale)) in panels.into_iter().enumerate() {
        let corner = (MARGIN + 62.0 + slot * (k % 2) as f64, 104.0 + step * (k / 2) as f64);
        let frame = Frame::fitted(corner, room, shape);
        frame.picture(&mut page, columns, places().map(|(x, y)| scale.colour(values(x, y))).collect());
        frame.heading(&mut page, heading, below);
        frame.metres(&mut page, [&axes[0], &axes[1]], names);
        frame.bar(&mut page, &scale, unit);
        if k < 2 {
            has_regions |= regions(&mut page, &frame, receiver);
        }
    }
    let foot = height - 40.0;
    if has_regions {
        legend(&mut page, (MARGIN, foot));
    }
    let words = match &receiver.judged {
        Judged::By(judged) => {
            let verdict = match judged.verdict {
                Verdict::Pass => "pass",
                Verdict::Fail => "FAIL",
                Verdict::Undecided => "undecided",
            };
            format!("{verdict}: {}", judged.words)
        }
        Judged::Not(why) => format!("not judged: {why}"),
    };
    page.text((MARGIN, foot + 22.0), words, SMALL, INK, Align::Start);
    page
}

/// A number with spaces between its thousands.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// What lies along the edges of a receiver's picture.
pub fn axis_names(shape: &ReceiverShape) -> [&'static str; 2] {
    match shape {
        ReceiverShape::Rectangle(_) => ["along edge_u (m)", "along edge_v (m)"],
        ReceiverShape::Sphere(_) => ["around the equator (m)", "height (m)"],
        ReceiverShape::Disk(_) | ReceiverShape::Triangle(_) => ["across (m)", "up (m)"],
    }
}

/// Draws where regions end; whether there was anything to draw.
pub fn regions(page: &mut Page, frame: &Frame, receiver: &ReceiverPicture) -> bool {
    let [columns, rows] = receiver.view.pixels();
    let stride = receiver.stride;
    let cells = [columns.div_ceil(stride), rows.div_ceil(stride)];
    let region = |i: usize, j: usize| {
        let place = ((i * stride).min(columns - 1), (j * stride).min(rows - 1));
        receiver.due_around(place.0, place.1).and_then(|(_, due)| due.region)
    };
    let drawn = std::cell::Cell::new(false);
    frame.outlines(page, cells, region, |a, b| {
        let pair = [(*a)?, (*b)?];
        let dark = |region: Region| matches!(region, Region::Umbra | Region::BelowHorizon);
        let found = match (dark(pair[0]), dark(pair[1])) {
            (true, false) | (false, true) => Some(UMBRA),
            (false, false) if (pair[0] == Region::Lit) != (pair[1] == Region::Lit) => Some(PENUMBRA),
            _ => None,
        };
        drawn.set(drawn.get() || found.is_some());
        found
    });
    drawn.get()
}

/// What the lines mean.
pub fn legend(page: &mut Page, (left, y): (f64, f64)) {
    let mut at = left;
    for (colour, words) in [(UMBRA, "the umbra ends (exact)"), (PENUMBRA, "the penumbra ends (exact)")] {
        page.line(vec![(at, y), (at + 22.0, y)], colour, 2.4, Dash::Solid);
        page.text((at + 28.0, y), words, SMALL, INK, Align::Start);
        at += 190.0;
    }
}
