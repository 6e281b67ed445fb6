//! How a cost grows: what was measured, the power of x through it, and the law that was expected.

use super::axis::Axis;
use super::ink::Page;
use super::panel::{HEIGHT, Key, Panel, WIDTH, legend_column, more_than_three, note, titled_page};
use super::style::{Colour, Dash, GUIDE, look};
use crate::report::growth::{affine, along, capital, exponent, nearer, proportion};
use crate::sampling::Strategy;
use crate::trial::GrowthStudy;

/// Beyond this, powers of ten are told instead of what was measured.
const FEW: u64 = 100_000;

/// `None` where nothing was measured.
pub fn growth(study: &GrowthStudy) -> Option<Page> {
    let fits = study.fits();
    let counts: Vec<u64> = study.observations.iter().map(|seen| seen.x).collect();
    let (least, most) = (*counts.iter().min()?, *counts.iter().max()?);
    let low = study.observations.iter().map(|seen| seen.seconds_low).fold(f64::INFINITY, f64::min);
    let high = study.observations.iter().map(|seen| seen.seconds_high).fold(0.0, f64::max);
    if !(low > 0.0 && least > 0) {
        return None;
    }
    let mut page = titled_page(study.title, &format!("seconds of {}, on one thread", study.timed));
    let (left, right, top, bottom) = (92.0, WIDTH - 40.0, 80.0, HEIGHT - 150.0);
    let x = if most < FEW {
        Axis::samples(&counts, (1.35, 1.35), right - left)
    } else {
        Axis::log(least as f64 / 1.35, most as f64 * 1.35, 10)
    };
    let panel = Panel { left, top, right, bottom, x, y: Axis::log(low / 1.8, high * 1.8, 12) };
    panel.draw(&mut page, study.quantity, "seconds");
    let mut legend = Vec::new();
    let line = look(Strategy::Random);
    let marks = look(Strategy::Correlated);
    let shown = |law: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let inside = |y: &f64| (panel.y.low()..=panel.y.high()).contains(y);
        along(study, law).into_iter().filter(|(_, y)| inside(y)).collect()
    };
    let mut draw = |pairs: Vec<(f64, f64)>, key: (Colour, f64, Dash), told: String| {
        let (colour, width, dash) = key;
        if pairs.len() > 1 {
            panel.curve(&mut page, pairs, colour, width, dash);
        }
        legend.push((Key::Line { colour, width, dash, marker: None }, told));
    };
    if let Some(power) = fits.power {
        // Straight here: its ends are enough.
        let pairs = ends(shown(&|x| power.at(x)));
        draw(pairs, (line.colour, 1.6, Dash::Solid), format!("fitted: x to the power of {}", exponent(&power)));
    }
    if let Some(fitted) = fits.affine {
        let colour = look(Strategy::Stratified).colour;
        draw(shown(&|x| fitted.at(x)), (colour, 1.6, Dash::Dashed), format!("fitted: {}", affine(&fitted)));
    }
    if let Some(law) = proportion(study) {
        draw(ends(shown(&law)), (GUIDE, 1.0, Dash::Solid), "in proportion to x, through the last".to_owned());
    }
    for seen in &study.observations {
        panel.bar(&mut page, (seen.x as f64, seen.seconds_low, seen.seconds_high), 0.0, 0.0, marks.colour);
        page.marker(panel.at(seen.x as f64, seen.seconds), marks.marker, marks.colour, 4.0);
    }
    let told = "measured: median of the repeats, bar from the quickest to the slowest".to_owned();
    legend.insert(0, (Key::Bar { colour: marks.colour, marker: marks.marker }, told));
    page.height += more_than_three(legend.len());
    legend_column(&mut page, (left, bottom + 62.0), &legend);
    let words = capital(&nearer(&fits)) + ", root mean square over the points.";
    note(&mut page, &words);
    Some(page)
}

/// The first and the last of several.
fn ends(pairs: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if pairs.len() < 2 { pairs } else { vec![pairs[0], pairs[pairs.len() - 1]] }
}
