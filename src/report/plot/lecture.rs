//! The figures of the lecture: a soft shadow and its regions, strategies side by side, maps with and without their
//! distortion, caustics.

use super::axis::Axis;
use super::ink::{Align, Page};
use super::panel::Panel;
use super::raster::{Frame, Scale};
use super::render::{PENUMBRA, UMBRA, axis_names, grouped, legend, regions};
use super::style::{Dash, GREY, INK, Marker, SMALL, TEXT, TITLE, look, shown};
use crate::eye::Picture;
use crate::oracle::Region;
use crate::report::image::{Rgb, Tone, colours, quantile};
use crate::sampling::Strategy;
use crate::trial::{Due, Lecture, ReceiverPicture};

/// The page, points.
const WIDTH: f64 = 960.0;
const MARGIN: f64 = 28.0;

/// File name, what it shows, the page.
pub fn pages(lecture: &Lecture) -> Vec<(&'static str, &'static str, Page)> {
    vec![
        ("soft-shadow.png", "a disk's soft shadow with its three regions", soft_shadow(lecture)),
        (
            "strategies.png",
            "random, shared and stratified points at 4, 16 and 64 for each pixel",
            strategies(lecture),
        ),
        (
            "textures.png",
            "textures and maps on a ball, a triangle and a globe, with and without distortion",
            textures(lecture),
        ),
        ("caustics.png", "caustics on a plane: a mirror ring, a glass ball, a cup", caustics(lecture)),
    ]
}

fn titled(height: f64, title: &str, below: &[&str]) -> Page {
    let mut page = Page::new(WIDTH, height);
    page.bold((MARGIN, 26.0), title, TITLE, INK, Align::Start);
    for (k, line) in below.iter().enumerate() {
        page.text((MARGIN, 48.0 + 18.0 * k as f64), *line, TEXT, GREY, Align::Start);
    }
    page
}

fn aside(page: &mut Page, frame: &Frame, picture: &Picture) {
    frame.picture(page, picture.width(), colours(picture, Tone::of_picture(picture)));
}

/// Irradiance of a receiver's pixels; `None` beside it.
fn irradiances(receiver: &ReceiverPicture) -> impl Iterator<Item = Option<f64>> {
    receiver.picture.pixels().iter().map(|pixel| pixel.lit.map(|lit| lit.irradiance()))
}

fn greys(receiver: &ReceiverPicture, scale: &Scale) -> Vec<Rgb> {
    irradiances(receiver).map(|value| scale.colour(value)).collect()
}

fn soft_shadow(lecture: &Lecture) -> Page {
    let (camera, receiver) = &lecture.shadow;
    let mut page = titled(
        760.0,
        "Soft shadow of a disk under a disk-shaped source",
        &[
            "No light in the umbra, some of the source in the penumbra, all of it beyond: the borders are exact, the picture is rendered.",
        ],
    );
    let room = Frame { left: MARGIN, top: 104.0, width: 420.0, height: 315.0 };
    aside(&mut page, &room, camera);
    room.heading(&mut page, "The room, from aside", "");
    let tone = Scale::Tone(Tone::of(irradiances(receiver).flatten()));
    let square = Frame { left: 540.0, top: 104.0, width: 315.0, height: 315.0 };
    square.picture(&mut page, receiver.picture.width(), greys(receiver, &tone));
    square.heading(&mut page, "The receiver, square on", "");
    let [across, up] = receiver.view.extent();
    let axes = [Axis::linear(0.0, across, false, 4), Axis::linear(0.0, up, false, 4)];
    square.metres(&mut page, [&axes[0], &axes[1]], axis_names(receiver.view.shape()));
    square.bar(&mut page, &tone, "W/m²");
    regions(&mut page, &square, receiver);
    legend(&mut page, (MARGIN, 444.0));

    // Along the middle row.
    let [columns, rows] = receiver.view.pixels();
    let along = |x: usize| across * (x as f64 + 0.5) / columns as f64;
    let middle: Vec<(f64, Due)> =
        (0..columns).filter_map(|x| receiver.due_around(x, rows / 2).map(|(_, due)| (along(x), due))).collect();
    let top = middle.iter().map(|(_, due)| due.irradiance).fold(0.0, f64::max);
    let panel = Panel {
        left: 100.0,
        top: 500.0,
        right: WIDTH - MARGIN,
        bottom: 690.0,
        x: Axis::linear(0.0, across, false, 8),
        y: Axis::linear(0.0, 1.12 * top, false, 4),
    };
    page.bold((MARGIN, 474.0), "Along the middle of the receiver", TEXT, INK, Align::Start);
    panel.draw(&mut page, "along edge_u (m)", "irradiance (W/m²)");
    let group = |region: Option<Region>| match region {
        Some(Region::Lit) => "lit",
        Some(Region::Umbra | Region::BelowHorizon) => "umbra",
        _ => "penumbra",
    };
    for run in middle.chunk_by(|a, b| group(a.1.region) == group(b.1.region)) {
        let half = 0.5 * across / columns as f64;
        let (from, to) = (run[0].0 - half, run[run.len() - 1].0 + half);
        let name = group(run[0].1.region);
        let colour = match name {
            "umbra" => UMBRA,
            "penumbra" => PENUMBRA,
            _ => GREY,
        };
        panel.band(&mut page, &[(from, 0.0, 1.12 * top), (to, 0.0, 1.12 * top)], colour, 0.16);
        let (x, y) = panel.at(0.5 * (from + to), 1.12 * top);
        page.text((x, y - 9.0), name, SMALL, INK, Align::Middle);
    }
    panel.curve(&mut page, middle.iter().map(|(x, due)| (*x, due.irradiance)), INK, 1.4, Dash::Solid);
    for x in (2..columns).step_by(6) {
        if let Some(lit) = receiver.picture.pixel(x, rows / 2).lit {
            let at = panel.at(along(x), lit.irradiance().min(1.12 * top));
            page.marker(at, Marker::Circle, look(Strategy::Stratified).colour, 1.8);
        }
    }
    let samples = receiver.settings.samples;
    let words = format!("line: exact; dots: rendered, stratified points, {samples} for each pixel");
    page.text((WIDTH - MARGIN, 474.0), words, SMALL, INK, Align::End);
    page
}

fn strategies(lecture: &Lecture) -> Page {
    let mut page = titled(
        1000.0,
        "The same shadow by three strategies",
        &[
            "Random points differ from pixel to pixel: grain. Shared points are the same for all: no grain, but as many sharp shadows as points.",
            "Stratified points differ, one in each stratum: the grain shrinks faster.",
        ],
    );
    let all = lecture.strategies.iter().flat_map(|(.., receiver)| receiver.due.iter().flatten());
    let scale = Scale::Tone(Tone::of(all.map(|due| due.irradiance)));
    let (side, step) = (250.0, (272.0, 290.0));
    let (left, top) = (MARGIN + 26.0, 120.0);
    for (k, (strategy, samples, receiver)) in lecture.strategies.iter().enumerate() {
        let (column, row) = (k % 3, k / 3);
        let frame =
            Frame { left: left + step.0 * column as f64, top: top + step.1 * row as f64, width: side, height: side };
        frame.picture(&mut page, receiver.picture.width(), greys(receiver, &scale));
        if row == 0 {
            let words = format!("{samples} points for each pixel");
            page.bold((frame.left + 0.5 * side, top - 13.0), words, TEXT, INK, Align::Middle);
        }
        if column == 0 {
            let at = (MARGIN + 6.0, frame.top + 0.5 * side);
            page.upwards(at, format!("{} points", shown_points(*strategy)), TEXT, INK, Align::Middle);
        }
        let words = rms(receiver)
            .map_or(String::new(), |rms| format!("rms error {:.1} % of the mean irradiance", 100.0 * rms));
        page.text((frame.left + 0.5 * side, frame.bottom() + 12.0), words, SMALL, INK, Align::Middle);
        if k == 2 {
            frame.bar(&mut page, &scale, "W/m²");
        }
    }
    page
}

fn shown_points(strategy: Strategy) -> &'static str {
    shown(strategy).strip_suffix(" points").unwrap_or(shown(strategy))
}

/// Root of the mean squared error over all pixels, over the mean of what is due.
fn rms(receiver: &ReceiverPicture) -> Option<f64> {
    let columns = receiver.picture.width();
    let pixels = 0..receiver.picture.pixels().len();
    let errors: Vec<f64> = pixels.filter_map(|k| receiver.error_around(k % columns, k / columns)).collect();
    let dues: Vec<f64> = receiver.due.iter().flatten().map(|due| due.irradiance).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let squares: Vec<f64> = errors.iter().map(|error| error * error).collect();
    (!squares.is_empty() && mean(&dues) > 0.0).then(|| mean(&squares).sqrt() / mean(&dues))
}

fn textures(lecture: &Lecture) -> Page {
    let of = &lecture.textures;
    let mut page = titled(
        655.0,
        "Maps on surfaces: what distorts them, and what undoes it",
        &["A chessboard looked up by (s, t), and light that rays left in the texels of a map."],
    );
    let (width, height) = (286.0, 214.5);
    let frame = |column: usize, row: usize| Frame {
        left: MARGIN + (width + 22.0) * column as f64,
        top: 128.0 + (height + 74.0) * row as f64,
        width,
        height,
    };
    let cells: [(usize, usize, &Picture, &str, &str); 5] = [
        (0, 0, &of.ball, "Ball: longitude and latitude", "fields shrink towards the poles"),
        (1, 0, &of.triangle[0], "Triangle on half the square", "uncorrected: the board is sheared"),
        (2, 0, &of.triangle[1], "Triangle on one similar to it", "corrected: squares are square"),
        (0, 1, &of.globe[0], "Caustic on a globe, uncorrected", "flux over the mean texel area: dark at the pole"),
        (1, 1, &of.globe[1], "The same, corrected", "flux over the exact area of each texel"),
    ];
    // Both globes by one white, low enough to see the ground that the caustic lies on.
    let radiosities =
        of.globe[1].pixels().iter().filter_map(|pixel| pixel.lit).map(|lit| lit.albedo * lit.irradiance());
    let globes = Tone { white: quantile(radiosities.filter(|value| *value > 0.0), 0.98).unwrap_or(1.0) };
    for (column, row, picture, heading, below) in cells {
        let frame = frame(column, row);
        let tone = if row == 1 { globes } else { Tone::of_picture(picture) };
        frame.picture(&mut page, picture.width(), colours(picture, tone));
        frame.heading(&mut page, heading, below);
    }
    let globe = frame(1, 1);
    globe.bar(&mut page, &Scale::Tone(globes), "radiosity, W/m²");
    let left = frame(2, 1).left + 62.0;
    for (k, line) in [
        "Near a pole a texel of a sphere’s map",
        "is narrow. Its area is",
        "",
        "   R² Δlongitude Δ(sin latitude),",
        "",
        "not a share of the map: divided by the",
        "wrong area, the brightest spot of the",
        "caustic is the darkest.",
    ]
    .into_iter()
    .enumerate()
    {
        page.text((left, globe.top + 30.0 + 18.0 * k as f64), line, SMALL, INK, Align::Start);
    }
    page
}

fn caustics(lecture: &Lecture) -> Page {
    let mut page = titled(
        660.0,
        "Caustics on a plane",
        &[
            "Above: the room, direct light and map together. Below: irradiance of the plane, square on, texel by texel.",
        ],
    );
    let (width, height) = (286.0, 214.5);
    for (k, caustic) in lecture.caustics.iter().enumerate() {
        let left = MARGIN + (width + 22.0) * k as f64;
        let room = Frame { left, top: 112.0, width, height };
        aside(&mut page, &room, &caustic.aside);
        room.heading(&mut page, &caustic.title, caustic.name);
        let receiver = &caustic.receiver;
        let white = quantile(irradiances(receiver).flatten().filter(|value| *value > 0.0), 0.998).unwrap_or(1.0);
        let scale = Scale::Tone(Tone { white });
        let [across, up] = receiver.view.extent();
        let plane = Frame::fitted((left + 40.0, 372.0), (196.0, 196.0), across / up);
        plane.picture(&mut page, receiver.picture.width(), greys(receiver, &scale));
        plane.bar(&mut page, &scale, "W/m²");
        let axes = [Axis::linear(0.0, across, false, 4), Axis::linear(0.0, up, false, 4)];
        plane.metres(&mut page, [&axes[0], &axes[1]], axis_names(receiver.view.shape()));
        let light = receiver.light.as_ref();
        let words = light.map_or(String::new(), |light| {
            format!("{} rays, {} × {} texels", grouped(light.rays), light.map[0], light.map[1])
        });
        page.text((left, plane.bottom() + 54.0), words, SMALL, GREY, Align::Start);
    }
    page
}
