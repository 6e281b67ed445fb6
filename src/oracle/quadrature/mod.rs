//! The second witness: the visible form factor of one source by strips across it, without any of the contour code.
//!
//! The source is cut into straight strips. The plane through the eye and a strip cuts every occluder in chords or a disk;
//! what these leave of the strip is integrated in closed form. Across the strips runs an adaptive Gauss–Kronrod rule,
//! between those strips at which the list of what crosses them changes its make-up: there the integrand is analytic,
//! with square-root ends at worst, which `s = middle + half sin θ` takes away. All terms are positive, so that the value
//! keeps its relative accuracy in deep shadow.
//!
//! A sphere source is integrated over the disk of its silhouette, which fills the same directions, while occluders are
//! held against the sphere itself; this also covers occluders that cut into a sphere source.
//!
//! The stated error is the difference between the rule and a much coarser one, and what the ends of stretches may be off
//! by. Openings narrower than that rounding are closed, and count in the error.
//!
//! - [`view`]: how the source looks from the eye · [`blocker`]: what an occluder hides of a strip
//! - [`curves`], [`breaks`]: where strips change · [`grain`]: lines on the source where its exitance does · [`strip`]: along one strip · [`rule`]: the rules
//! - [`witness`]: the public questions

mod blocker;
mod breaks;
mod curves;
mod grain;
pub(super) mod rule;
mod strip;
mod view;
mod witness;

use std::cell::Cell;

use glam::DVec3;

use super::body::Body;
use super::textured::PRECISE;
pub(super) use grain::{Grain, Line};
use rule::{Demand, Ends};
use strip::{Emission, Held, PATIENCE, Walk};
use view::View;

/// Visible form factor by quadrature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Strips {
    pub value: f64,
    /// Sum of the rule's own error estimates, and rounding.
    pub error: f64,
    /// Whether some strip sees part of the source; whether some strip has part of it hidden by an occluder.
    pub seen: bool,
    pub hidden: bool,
    /// Whether the horizon cuts it.
    pub cut: bool,
    /// With all occluders away.
    pub unoccluded: f64,
    pub unoccluded_error: f64,
}

/// The same of an exitance that varies: form factors times exitance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WeightedStrips {
    pub factor: Strips,
    pub value: f64,
    pub unoccluded: f64,
    /// Of either.
    pub error: f64,
}

/// - `occluders`: every body that may hide part of the source
/// - returns zero for a source that turns its dark side or is seen from inside
pub(super) fn visible(n: DVec3, source: &Body, occluders: &[&Body], eye: DVec3) -> Strips {
    walk(n, source, occluders, eye, None, None, PRECISE).factor
}

/// - `emission`: exitance at a place on the source, given relative to `source.center`; where it is not a finite number,
///   it counts as none and the error is infinite
pub(super) fn visible_weighted(
    n: DVec3,
    source: &Body,
    occluders: &[&Body],
    eye: DVec3,
    emission: Emission,
) -> WeightedStrips {
    weighted(n, source, occluders, eye, emission, None, PRECISE)
}

/// The same, the emission being smooth, or constant, between known lines.
///
/// - `precision`: errors that will do, relative
pub(super) fn visible_between(
    n: DVec3,
    source: &Body,
    occluders: &[&Body],
    eye: DVec3,
    emission: Emission,
    grain: &Grain,
    precision: f64,
) -> WeightedStrips {
    weighted(n, source, occluders, eye, emission, Some(grain), precision)
}

fn weighted(
    n: DVec3,
    source: &Body,
    occluders: &[&Body],
    eye: DVec3,
    emission: Emission,
    grain: Option<&Grain>,
    precision: f64,
) -> WeightedStrips {
    let is_finite = Cell::new(true);
    let finite = |place: DVec3| {
        let value = emission(place);
        if value.is_finite() {
            value
        } else {
            is_finite.set(false);
            0.0
        }
    };
    let found = walk(n, source, occluders, eye, Some(&finite), grain, precision);
    WeightedStrips { error: if is_finite.get() { found.error } else { f64::INFINITY }, ..found }
}

fn walk(
    n: DVec3,
    source: &Body,
    occluders: &[&Body],
    eye: DVec3,
    emission: Option<Emission>,
    grain: Option<&Grain>,
    precision: f64,
) -> WeightedStrips {
    /// Panels after which those that remain are taken as they are.
    const BUDGET: usize = 6000;
    let Some(view) = View::new(n, source, occluders, eye) else { return WeightedStrips::default() };
    let grain = grain.map(|grain| grain.seen(&view));
    let ends = breaks::breaks(&view, grain.as_ref());
    let (low, high) = view.extent();
    let mut walk = Walk::new(&view, emission, grain.as_ref());
    let asked = Cell::new(0);
    let found = rule::integrate(
        &ends,
        Ends::Roots,
        1e-15 * (high - low),
        BUDGET,
        |sigma| {
            let held = walk.along(sigma);
            asked.set(walk.asked.get());
            held.to_array()
        },
        |sum| Demand { goal: goals(sum, asked.get() < PATIENCE, precision), floor },
    );
    let (sum, error) = (Held::from_array(found.value), Held::from_array(found.error));
    // A form factor feels its height by no more than its fourth power.
    let rounding = 8.0 * f64::EPSILON + 4.0 * view.height_doubt;
    let factor = Strips {
        value: sum.visible,
        error: error.visible + sum.doubt + rounding * sum.visible,
        seen: walk.sight.seen,
        hidden: walk.sight.hidden,
        cut: walk.sight.cut,
        unoccluded: sum.whole,
        unoccluded_error: error.whole + rounding * sum.whole,
    };
    let brightest = if sum.whole > 0.0 { sum.emission_size / sum.whole } else { 0.0 };
    WeightedStrips {
        factor,
        value: sum.visible_emission,
        unoccluded: sum.whole_emission,
        // Ends that are off, at the source's mean exitance: they are far below the rest.
        error: error.visible_emission.max(error.whole_emission)
            + sum.emission_error
            + brightest * sum.doubt
            + rounding * sum.emission_size,
    }
}

/// Errors that will do: in deep shadow, relative to what is seen there.
fn goals(sum: &[f64; strip::N], patient: bool, precision: f64) -> [f64; strip::N] {
    let sum = Held::from_array(*sum);
    let emission = if patient { precision * sum.emission_size } else { f64::INFINITY };
    Held {
        visible: precision * sum.visible + 1e-17 * sum.whole,
        whole: precision * sum.whole,
        doubt: f64::INFINITY,
        visible_emission: emission,
        whole_emission: emission,
        emission_size: f64::INFINITY,
        emission_error: f64::INFINITY,
    }
    .to_array()
}

/// Errors of one panel that are noise.
fn floor(panel: &[f64; strip::N]) -> [f64; strip::N] {
    let panel = Held::from_array(*panel);
    let rounding = 8.0 * f64::EPSILON;
    Held {
        visible: panel.doubt + rounding * panel.visible,
        whole: rounding * panel.whole,
        visible_emission: panel.emission_error + rounding * panel.emission_size,
        whole_emission: panel.emission_error + rounding * panel.emission_size,
        ..Held::default()
    }
    .to_array()
}
