//! Averages of the exact irradiance over a patch, and form factors between any two patches behind any occluders.
//!
//! Two nested quadratures of the exact point value, never a four-dimensional one: strips over the patch, and along each
//! strip panels between the places where what is seen changes its kind. Both are split there; between, the value is analytic.
//!
//! Limit: a bound here is a careful estimate, not a proof. What no node sees (a shadow that meets no edge of the patch and
//! is much smaller than a seventh of it, at a fine tolerance a twentieth) is not in it.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;

use glam::DVec3;

use super::PatchError;
use super::adaptive::{self, Integral, Node, Spec};
use super::surface::{Layout, Patch};
use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use crate::geometry::Shape;
use crate::oracle::exact::{self, Oracle};
use crate::radiometry::{Exitance, FormFactor, Irradiance};

/// How good an average has to be. It stops where either is reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// In units of the average itself.
    pub relative: f64,
    /// W/m².
    pub absolute: f64,
    /// Evaluations of the exact point value after which the work ends with the bound that it has.
    pub most_evaluations: u64,
}

impl Tolerance {
    /// - `relative`: below 1e-13 the rounding of sums is in the way
    pub fn relative(relative: f64) -> Tolerance {
        Tolerance { relative, absolute: 0.0, most_evaluations: 20_000_000 }
    }
}

impl Default for Tolerance {
    /// 1e-10, relative.
    fn default() -> Tolerance {
        Tolerance::relative(1e-10)
    }
}

/// The mean of the exact irradiance over a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Average {
    /// The mean over the patch, W/m².
    pub irradiance: Irradiance,
    /// Estimated error: of both quadratures, of the point values, of rounding; it may be larger than what was asked for.
    pub bound: Irradiance,
    /// Of the exact point value.
    pub evaluations: u64,
}

/// From this tolerance on, one first panel and a coarse place for each change of kind.
const COARSE: f64 = 1e-8;
/// First panels of a strip, and of each band of strips, at fine tolerances.
const FINE_PANELS: u32 = 3;
/// Places remembered from strip to strip.
const MOST_MIDDLES: usize = 8;
/// The bound over the sum of the panels' own estimates. Where kinks were left to halving, the sum was up to 2.2 times too
/// small.
const CAUTION: f64 = 4.0;
/// Coordinates in units of a patch's size beyond which their rounding shows in its average.
const REMOTE: f64 = 64.0;
/// Passes over the patch: the next one is made only if the last fell short, with what it has learnt of the average.
const PASSES: u32 = 3;

/// The mean of the exact irradiance over a patch: what a pixel with that footprint records.
///
/// ```text
/// Ē = (1/A) ∫_patch E(x) dA
/// ```
///
/// - `patch`: receives on the side of its normal; it blocks no light
/// - returns W/m²; the same on every machine and in every order of calls
/// - error: `bound`, an estimate (see the module's limit)
/// - source: nested Gauss–Kronrod–Patterson quadrature of [`Oracle::at`]; second witness: the closed forms of this module
pub fn average_irradiance(oracle: &Oracle, patch: &Patch, tolerance: Tolerance) -> Average {
    let field = |point: &MeasurementPoint| {
        let seen = oracle.seen(point);
        let truth = oracle.together(&seen);
        Value {
            irradiance: truth.irradiance.watts_per_square_metre(),
            bound: truth.bound.watts_per_square_metre(),
            unoccluded: truth.unoccluded_irradiance.watts_per_square_metre(),
            kind: exact::topology(&seen),
        }
    };
    average_of(&field, patch, tolerance)
}

/// A field at one point, W/m².
#[derive(Clone, Copy, Debug)]
pub(in crate::oracle) struct Value {
    pub irradiance: f64,
    pub bound: f64,
    /// A first look's stand-in where little is seen.
    pub unoccluded: f64,
    /// Equal where the field is smooth in between.
    pub kind: u64,
}

/// The same of any field that is analytic between places where its kind changes.
pub(in crate::oracle) fn average_of(
    field: &dyn Fn(&MeasurementPoint) -> Value,
    patch: &Patch,
    tolerance: Tolerance,
) -> Average {
    let work = Work {
        field,
        normal: patch.normal(),
        layout: patch.layout(),
        evaluations: Cell::new(0),
        most: tolerance.most_evaluations,
        is_coarse: tolerance.relative >= COARSE,
    };
    let area = patch.area();
    let wanted = |integral: f64| (tolerance.relative * integral.abs()).max(tolerance.absolute * area);
    let (guess, unoccluded) = work.look();
    // Where little is seen at first, a share of what would be without occluders stands in.
    let mut target = 0.5 * wanted(guess.max(1e-3 * unoccluded));
    let mut best: Option<Integral<()>> = None;
    for _ in 0..PASSES {
        let mut found = work.pass(target / CAUTION, area);
        found.error *= CAUTION;
        let is_better = best.as_ref().is_none_or(|best| found.error < best.error);
        let (value, error) = (found.value, found.error);
        if is_better {
            best = Some(found);
        }
        let wanted = wanted(value);
        // What is left to the point values and to rounding no further pass takes away.
        if error <= wanted || !is_better || work.is_spent() || wanted == 0.0 {
            break;
        }
        target = 0.5 * wanted * (target / error).min(1.0);
    }
    let best =
        best.unwrap_or(Integral { value: guess, error: f64::INFINITY, kinds: Vec::new(), changes: Vec::new() });
    Average {
        irradiance: Irradiance::new(best.value / area),
        bound: Irradiance::new(best.error / area),
        evaluations: work.evaluations.get(),
    }
}

/// A form factor between finite patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchFactor {
    /// Of what leaves the first patch, the share that reaches the second.
    pub form_factor: FormFactor,
    /// Estimated error, as of [`Average`]; a pure number.
    pub bound: f64,
    /// Of the exact point value.
    pub evaluations: u64,
}

/// Form factor from one patch to another, past any occluders.
///
/// The mean over the first patch of the exact factor from a point to the second:
///
/// ```text
/// F₁₂ = (1/A₁) ∫_{A₁} F(x → 2) dA
/// ```
///
/// - `from`, `to`: each leaves or receives on the side of its normal; neither blocks light
/// - `occluders`: block from both sides
/// - error: `bound`, an estimate (see the module's limit)
/// - source: [`average_irradiance`]; second witness: reciprocity, and a one-dimensional integral for an L-shaped room
pub fn patch_to_patch(
    from: &Patch,
    to: &Patch,
    occluders: &[Shape],
    tolerance: Tolerance,
) -> Result<PatchFactor, PatchError> {
    let source = Source::new(to.shape(), Exitance::new(1.0)).map_err(|refused| vec![refused])?;
    // A configuration measures somewhere: beyond everything, where nothing can be in the way.
    let shapes = occluders.iter().chain([source.shape()]);
    let beyond = shapes.map(|shape| shape.bounds().1).fold(DVec3::ONE, DVec3::max);
    let point = MeasurementPoint::new(beyond + beyond.abs(), DVec3::Z).map_err(|_| PatchError::OutOfRange)?;
    let room = Configuration::new(vec![source], occluders.to_vec(), None, vec![point], Arrangement::Scattered)?;
    let average = average_irradiance(&Oracle::new(&room), from, tolerance);
    Ok(PatchFactor {
        form_factor: FormFactor::new(average.irradiance.watts_per_square_metre()),
        bound: average.bound.watts_per_square_metre(),
        evaluations: average.evaluations,
    })
}

struct Work<'a> {
    field: &'a dyn Fn(&MeasurementPoint) -> Value,
    normal: DVec3,
    layout: Layout,
    evaluations: Cell<u64>,
    most: u64,
    is_coarse: bool,
}

impl Work<'_> {
    fn is_spent(&self) -> bool {
        self.evaluations.get() >= self.most
    }

    /// The irradiance at a place with its kind, the shadow's topology. Nothing is seen from where there is no place:
    /// coordinates beyond the range of f64.
    fn value(&self, s: f64, t: f64) -> Option<Value> {
        self.evaluations.set(self.evaluations.get() + 1);
        let point = MeasurementPoint::new(self.layout.point(s, t), self.normal).ok()?;
        Some((self.field)(&point))
    }

    /// A first look at the integrals of irradiance, with and without occluders: 4 × 4 points a band.
    fn look(&self) -> (f64, f64) {
        let (mut seen, mut unoccluded) = (0.0, 0.0);
        const PLACES: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
        for band in &self.layout.bands {
            for share in PLACES {
                let (stretch, s, spans) = self.layout.strip(band, band.from + (band.to - band.from) * share);
                for [low, high] in spans {
                    for share in PLACES {
                        let weight = stretch * (band.to - band.from) * (high - low) / 16.0;
                        if let Some(value) = self.value(s, low + (high - low) * share) {
                            seen += weight * value.irradiance;
                            unoccluded += weight * value.unoccluded;
                        }
                    }
                }
            }
        }
        (seen, unoccluded)
    }

    /// The integral over the patch, each part of it good to its share of `target`.
    fn pass(&self, target: f64, area: f64) -> Integral<()> {
        let bands: f64 = self.layout.bands.iter().map(|band| band.to - band.from).sum();
        let blur = self.layout.blur();
        let spec = |density: f64, total: f64| Spec {
            blur: if blur > REMOTE * f64::EPSILON * total { blur } else { 0.0 },
            density,
            floor: 1e-3 * density * total,
            // What is off by η in a place from which the value leaves like δ^{3/2} is off by η^{5/2}.
            resolution: if self.is_coarse { 1e-4 } else { 1e-8 },
        };
        let outer = spec(0.5 * target / bands, bands);
        // An area's share of the target; the inner sums look smooth to the outer one.
        let inner_density = 0.1 * target / area;
        let mut sum = Integral { value: 0.0, error: 0.0, kinds: Vec::new(), changes: Vec::new() };
        // The middles of what the last strips were made of: what is narrow there may be narrower in the next.
        let middles: RefCell<VecDeque<f64>> = RefCell::default();
        for band in &self.layout.bands {
            let strip = |variable: f64| {
                let (stretch, s, spans) = self.layout.strip(band, variable);
                let mut whole = Node { value: 0.0, error: 0.0, kind: Vec::new() };
                for [low, high] in spans {
                    let inner = spec(inner_density, high - low);
                    let mut pieces = vec![low];
                    let probes: Vec<f64> = middles.borrow().iter().copied().collect();
                    self.panels(low, high, |ends| {
                        let node = |t: f64| self.node(s, t);
                        let part = adaptive::integrate(node, ends, [false; 2], &probes, inner, || self.is_spent());
                        whole.value += stretch * part.value;
                        whole.error += stretch * part.error;
                        pieces.extend(part.changes);
                        // Panels of one strip that meet in one kind are one stretch of it.
                        let again = usize::from(whole.kind.last() == part.kinds.first());
                        whole.kind.extend(part.kinds.into_iter().skip(again));
                    });
                    pieces.push(high);
                    if pieces.len() > 2 {
                        let mut middles = middles.borrow_mut();
                        middles.extend(pieces.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])));
                        let surplus = middles.len().saturating_sub(MOST_MIDDLES);
                        middles.drain(..surplus);
                    }
                }
                whole
            };
            self.panels(band.from, band.to, |ends| {
                let part = adaptive::integrate(strip, ends, [false; 2], &[], outer, || self.is_spent());
                sum.value += part.value;
                sum.error += part.error;
            });
        }
        sum
    }

    fn panels(&self, low: f64, high: f64, mut panel: impl FnMut([f64; 2])) {
        let panels = if self.is_coarse { 1 } else { FINE_PANELS };
        let end = |i: u32| low + (high - low) * (f64::from(i) / f64::from(panels));
        (0..panels).for_each(|i| panel([end(i), end(i + 1)]));
    }

    fn node(&self, s: f64, t: f64) -> Node<u64> {
        match self.value(s, t) {
            Some(found) => Node { value: found.irradiance, error: found.bound, kind: found.kind },
            None => Node { value: 0.0, error: f64::INFINITY, kind: u64::MAX },
        }
    }
}
