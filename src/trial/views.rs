//! Small pictures of receivers for a report: what is exact, what each strategy makes of it, and what lies between.

use rayon::prelude::*;

use super::settings::Settings;
use crate::case::Case;
use crate::eye::{Caustics, Direct, Eye, Shading, View};
use crate::oracle::{Method, Oracle};
use crate::sampling::Strategy;

/// Longer side, pixels.
const LONGEST: usize = 80;
/// Points on each source for each pixel: few enough that noise shows.
pub const SAMPLES: u64 = 16;
/// More strategies are not shown.
const MOST: usize = 4;

/// A receiver square on, `[height][width]`; `None` beside it. W/m².
#[derive(Clone, Debug, PartialEq)]
pub struct ReceiverViews {
    /// The case's name.
    pub case: String,
    pub size: [usize; 2],
    /// At the middle of each pixel.
    pub exact: Vec<Option<f64>>,
    /// By each of the study's strategies.
    pub estimates: Vec<(Strategy, Vec<Option<f64>>)>,
}

/// The views of all cases that have some: not where light is bent or sent on, where there is no receiver, or where exact
/// values would take long.
pub fn receiver_views<'a>(cases: impl Iterator<Item = &'a Case>, settings: &Settings) -> Vec<ReceiverViews> {
    let of = |case: &Case| of_case(case, &settings.study(&case.study).strategies, settings.seed);
    cases.filter_map(of).collect()
}

fn of_case(case: &Case, strategies: &[Strategy], seed: u64) -> Option<ReceiverViews> {
    let room = &case.configuration;
    if room.sources().is_empty() || room.has_optics() || !room.diffuse().is_empty() || strategies.is_empty() {
        return None;
    }
    let view = View::of_receiver(room, LONGEST).ok()?;
    let View::Receiver(of_receiver) = view else { return None };
    let size @ [width, height] = of_receiver.pixels();
    let oracle = Oracle::new(room);
    let element = |k: usize| of_receiver.element((k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
    let probe = |k: &usize| element(*k).is_some_and(|point| oracle.at(&point).method == Method::Quadrature);
    // Some places all over tell whether there is a closed form.
    if (0..width * height).step_by((width * height / 60).max(1)).any(|k| probe(&k)) {
        return None;
    }
    let eye = Eye::new(room, view, Direct::new(room)).ok()?;
    let exact: Vec<Option<f64>> = (0..width * height)
        .into_par_iter()
        .map(|k| element(k).map(|point| oracle.at(&point).irradiance.watts_per_square_metre()))
        .collect();
    if exact.iter().flatten().all(|value| *value == 0.0) {
        return None;
    }
    let estimates = strategies.iter().take(MOST).map(|strategy| {
        let shading = Shading { strategy: *strategy, samples: SAMPLES, seed };
        let picture = eye.picture(&shading, &Caustics::none());
        (*strategy, picture.pixels().iter().map(|pixel| pixel.lit.map(|lit| lit.irradiance())).collect())
    });
    Some(ReceiverViews { case: case.name.clone(), size, exact, estimates: estimates.collect() })
}
