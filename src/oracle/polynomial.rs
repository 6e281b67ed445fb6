//! Rectangles whose exitance is a polynomial of second degree.
//!
//! At height h above the foot of a point whose plane is parallel to the rectangle, cosθᵢ = cosθₛ = h/r, and the
//! irradiance is a sum of moments over the rectangle, (s, t) from the foot:
//!
//! ```text
//! E = (h²/π) Σ e_ij M_ij,    M_ij = ∫∫ sⁱ tʲ / (h² + s² + t²)² ds dt
//! ```
//!
//! M_ij is the four-corner difference of G_ij; with a = √(h² + s²), b = √(h² + t²), A = atan(t/a), B = atan(s/b):
//!
//! ```text
//! G00 = (s A/a + t B/b) / 2h²    G10 = −A/2a    G01 = −B/2b    G11 = −ln(h² + s² + t²)/4
//! G20 = (J − s A/a)/2            G02 = (J − t B/b)/2
//! J(s, t) = ∫₀ˢ∫₀ᵗ ds dt / (h² + s² + t²) = ∫₀^asinh(t/h) atan(s / (h cosh y)) dy
//! ```
//!
//! J is not elementary; its integrand in y is smooth, and Gauss's rule on short panels gives it to rounding. Far from
//! the foot the differences cancel; there the defining integral itself is smooth, and a product of Gauss's rules takes
//! over. (Chen & Arvo 2000 found the same of linearly varying luminaires: elementary where parallel, dilogarithms else.)

use std::f64::consts::PI;

use glam::DVec3;

use super::body::Body;
use super::quadrature::visible_weighted;
use super::truth::{Method, Region, Truth};
use crate::configuration::MeasurementPoint;
use crate::geometry::{Rectangle, Shape};
use crate::number::gauss_10;
use crate::radiometry::{Exitance, Flux, FormFactor, Irradiance};
pub use crate::texture::ExitancePolynomial;

/// A value and how far off it may be.
#[derive(Clone, Copy, Debug)]
struct Bounded {
    value: f64,
    bound: f64,
}

impl ExitancePolynomial {
    /// The exitance `s`, `t` metres from the centre.
    pub fn at(&self, s: f64, t: f64) -> Exitance {
        Exitance::new(self.value(s, t))
    }

    /// The exitance at a position (metres) on a rectangle; beside its plane, that of the nearest point in it.
    pub fn at_position(&self, rectangle: &Rectangle, position: DVec3) -> Exitance {
        Exitance::new(self.value_at(rectangle, position))
    }

    /// All the power that leaves a rectangle: A (e00 + e20 a²/12 + e02 b²/12), with edges a, b and area A.
    pub fn flux(&self, rectangle: &Rectangle) -> Flux {
        Flux::new(self.mean(rectangle) * rectangle.area())
    }

    /// The irradiance at a point that sees all of the rectangle which its horizon leaves, nothing being in the way.
    ///
    /// In closed form where the point's plane is parallel to the rectangle's (but for one smooth integral), else by
    /// [strips](super::Oracle::by_quadrature_with), which also answers where something is in the way.
    ///
    /// - `form_factor` and `region` of the answer are the rectangle's, whatever it emits
    /// - error: at most `bound`; a few units in the last place of ∫ |exitance| where parallel, 1e-11 of it in other poses
    pub fn irradiance(&self, rectangle: &Rectangle, point: &MeasurementPoint) -> Truth {
        let (normal, n) = (rectangle.normal(), point.normal());
        let (u, v) = (rectangle.edge_u().normalize(), rectangle.edge_v().normalize());
        let apart = rectangle.center() - point.position();
        let height = -normal.dot(apart);
        let is_parallel = normal.cross(n).length() <= 4.0 * f64::EPSILON && normal.dot(n) < 0.0;
        let is_above = height
            > 4.0 * f64::EPSILON * (apart.length() + rectangle.edge_u().length().max(rectangle.edge_v().length()));
        if !(is_parallel && is_above && u.dot(v).abs() <= 4.0 * f64::EPSILON) {
            return self.by_strips(rectangle, point);
        }
        let panel = Panel {
            height,
            center: [apart.dot(u), apart.dot(v)],
            half: [0.5 * rectangle.edge_u().length(), 0.5 * rectangle.edge_v().length()],
        };
        let (found, method) = panel.irradiance(self);
        let (factor, _) = panel.irradiance(&ExitancePolynomial { e00: 1.0, ..Default::default() });
        Truth {
            irradiance: Irradiance::new(found.value),
            unoccluded_irradiance: Irradiance::new(found.value),
            form_factor: FormFactor::new(factor.value),
            // A height that is the difference of larger numbers is off by their rounding.
            bound: Irradiance::new(found.bound + self.sensitivity(&panel, normal, apart) * factor.value),
            region: Region::Lit,
            method,
            shadow_edge: false,
        }
    }

    /// What rounding of the pose makes of the irradiance, per form factor.
    fn sensitivity(&self, panel: &Panel, normal: DVec3, apart: DVec3) -> f64 {
        let off = f64::EPSILON * normal.abs().dot(apart.abs()) / panel.height;
        let [a, b] = panel.half;
        let largest = self.e00.abs() + self.e10.abs() * a + self.e01.abs() * b;
        4.0 * off * (largest + self.e20.abs() * a * a + self.e11.abs() * a * b + self.e02.abs() * b * b)
    }

    fn by_strips(&self, rectangle: &Rectangle, point: &MeasurementPoint) -> Truth {
        let bodies = Body::of_shape(&Shape::Rectangle(*rectangle), 1.0);
        let emission =
            |place: DVec3| self.at_position(rectangle, rectangle.center() + place).watts_per_square_metre();
        let found = visible_weighted(point.normal(), &bodies[0], &[], point.position(), &emission);
        Truth {
            irradiance: Irradiance::new(found.value),
            unoccluded_irradiance: Irradiance::new(found.unoccluded),
            form_factor: FormFactor::new(found.factor.value),
            bound: Irradiance::new(found.error),
            region: match (found.factor.seen, found.factor.cut) {
                (false, _) => Region::BelowHorizon,
                (true, true) => Region::Penumbra,
                (true, false) => Region::Lit,
            },
            method: Method::Quadrature,
            shadow_edge: false,
        }
    }

    /// The same polynomial of coordinates whose origin is the foot, the centre being at (s, t).
    fn about_foot(&self, s: f64, t: f64) -> ExitancePolynomial {
        ExitancePolynomial {
            e00: self.value(-s, -t),
            e10: self.e10 - 2.0 * self.e20 * s - self.e11 * t,
            e01: self.e01 - 2.0 * self.e02 * t - self.e11 * s,
            ..*self
        }
    }
}

/// A rectangle above a parallel point's foot.
struct Panel {
    height: f64,
    /// From the foot.
    center: [f64; 2],
    half: [f64; 2],
}

impl Panel {
    fn irradiance(&self, exitance: &ExitancePolynomial) -> (Bounded, Method) {
        let closed = self.by_corners(exitance);
        if closed.bound <= 16.0 * f64::EPSILON * closed.value.abs() {
            return (closed, Method::ClosedForm);
        }
        let cubature = self.by_cubature(exitance);
        if closed.bound <= cubature.bound { (closed, Method::ClosedForm) } else { (cubature, Method::Quadrature) }
    }

    fn by_corners(&self, exitance: &ExitancePolynomial) -> Bounded {
        let h = self.height;
        let [s, t] = self.center;
        let e = exitance.about_foot(s, t);
        let (s, t) = ([s - self.half[0], s + self.half[0]], [t - self.half[1], t + self.half[1]]);
        let (a, b) = (s.map(|s| h.hypot(s)), t.map(|t| h.hypot(t)));
        // atan(t/a) and atan(s/b) between the sides.
        let over_t = a.map(|a| angle_between(t, a));
        let over_s = b.map(|b| angle_between(s, b));
        let sum = |terms: [f64; 2]| Bounded { value: terms[1] - terms[0], bound: terms[0].abs() + terms[1].abs() };
        let first = sum([s[0] * over_t[0] / a[0], s[1] * over_t[1] / a[1]]);
        let second = sum([t[0] * over_s[0] / b[0], t[1] * over_s[1] / b[1]]);
        let tilt_s = sum([over_t[0] / a[0], over_t[1] / a[1]]);
        let tilt_t = sum([over_s[0] / b[0], over_s[1] / b[1]]);
        // ln q at four corners, q = a² + t²: their products differ by (s₂² − s₁²)(t₂² − t₁²).
        let corner = |i: usize, j: usize| a[i] * a[i] + t[j] * t[j];
        let cross = (s[1] - s[0]) * (s[1] + s[0]) * (t[1] - t[0]) * (t[1] + t[0]) / (corner(0, 1) * corner(1, 0));
        let log = (-cross).ln_1p();
        let j = if e.e20 == 0.0 && e.e02 == 0.0 { 0.0 } else { j_between(h, s, t) };
        // Each with the sum of the magnitudes that went into it.
        let terms = [
            (e.e00 / (2.0 * h * h), Bounded { value: first.value + second.value, bound: first.bound + second.bound }),
            (-0.5 * e.e10, tilt_s),
            (-0.5 * e.e01, tilt_t),
            (0.5 * e.e20, Bounded { value: j - first.value, bound: j.abs() + first.bound }),
            (-0.25 * e.e11, Bounded { value: log, bound: log.abs() }),
            (0.5 * e.e02, Bounded { value: j - second.value, bound: j.abs() + second.bound }),
        ];
        let factor = h * h / PI;
        // The shift to the foot has rounded too: its terms may be larger than what is left of them.
        let [cs, ct] = self.center.map(f64::abs);
        let x = exitance;
        let shifted = [
            x.e00.abs()
                + cs * x.e10.abs()
                + ct * x.e01.abs()
                + cs * cs * x.e20.abs()
                + cs * ct * x.e11.abs()
                + ct * ct * x.e02.abs(),
            x.e10.abs() + 2.0 * cs * x.e20.abs() + ct * x.e11.abs(),
            x.e01.abs() + 2.0 * ct * x.e02.abs() + cs * x.e11.abs(),
        ];
        let [k00, k10, k01] = [shifted[0] / (2.0 * h * h), 0.5 * shifted[1], 0.5 * shifted[2]];
        let rounded = k00 * terms[0].1.value.abs() + k10 * tilt_s.value.abs() + k01 * tilt_t.value.abs();
        let size: f64 = terms.iter().map(|(c, term)| c.abs() * term.bound).sum();
        Bounded {
            value: factor * terms.iter().map(|(c, term)| c * term.value).sum::<f64>(),
            bound: factor * f64::EPSILON * (4.0 * size + 2.0 * rounded),
        }
    }

    /// The defining integral by products of Gauss's rules, on parts that are small for their distance.
    fn by_cubature(&self, exitance: &ExitancePolynomial) -> Bounded {
        let h = self.height;
        let (mut value, mut size) = (0.0, 0.0);
        // Parts relative to the centre, so that a small rectangle far away keeps its digits.
        let mut parts = vec![([0.0, 0.0], self.half)];
        while let Some((middle, half)) = parts.pop() {
            let distance = (self.center[0] + middle[0]).hypot(self.center[1] + middle[1]).hypot(h);
            let long = usize::from(half[1] > half[0]);
            if half[long] > 0.2 * distance {
                for side in [-0.5, 0.5] {
                    let (mut part, mut quarter) = (middle, half);
                    part[long] += side * half[long];
                    quarter[long] *= 0.5;
                    parts.push((part, quarter));
                }
                continue;
            }
            let mut magnitude = 0.0;
            value += gauss_10(middle[0], half[0], |s| {
                gauss_10(middle[1], half[1], |t| {
                    let (x, y) = (self.center[0] + s, self.center[1] + t);
                    let square = h * h + x * x + y * y;
                    let here = exitance.value(s, t) / (square * square);
                    magnitude = f64::max(magnitude, here.abs());
                    here
                })
            });
            size += magnitude * 4.0 * half[0] * half[1];
        }
        let factor = h * h / PI;
        Bounded { value: factor * value, bound: 8.0 * f64::EPSILON * factor * size }
    }
}

/// atan(x₂/c) − atan(x₁/c) for c > 0.
fn angle_between([from, to]: [f64; 2], c: f64) -> f64 {
    ((to - from) * c).atan2(c * c + from * to)
}

/// The four-corner difference of J.
fn j_between(h: f64, s: [f64; 2], t: [f64; 2]) -> f64 {
    /// Panels in y this long are smooth: the integrand's nearest singularities are at ±iπ/2 or where a tangent is ±i.
    const LENGTH: f64 = 0.25;
    let (from, to) = ((t[0] / h).asinh(), (t[1] / h).asinh());
    let n = ((to - from) / LENGTH).ceil().max(1.0);
    let half = 0.5 * (to - from) / n;
    (0..n as usize)
        .map(|i| gauss_10(from + half * (2.0 * i as f64 + 1.0), half, |y| angle_between(s, h * y.cosh())))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn coefficients() -> impl proptest::strategy::Strategy<Value = ExitancePolynomial> {
        let x = || -1.0..1.0;
        (x(), x(), x(), x(), x(), x()).prop_map(|(e00, e10, e01, e20, e11, e02)| ExitancePolynomial {
            e00,
            e10,
            e01,
            e20,
            e11,
            e02,
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn corners_cubature_and_strips_agree(
            e in coefficients(),
            (x, y) in (-3.0..3.0, -3.0..3.0),
            (a, b) in (0.01..2.0, 0.01..2.0),
            height in 0.05..3.0,
        ) {
            let panel = Panel { height, center: [y, x], half: [0.5 * b, 0.5 * a] };
            let (corners, cubature) = (panel.by_corners(&e), panel.by_cubature(&e));
            let apart = (corners.value - cubature.value).abs();
            prop_assert!(apart <= corners.bound + cubature.bound, "{corners:?} {cubature:?}");
            let rectangle = Rectangle::new(DVec3::new(x, y, height), DVec3::Y * b, DVec3::X * a).unwrap();
            let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
            let (truth, strips) = (e.irradiance(&rectangle, &point), e.by_strips(&rectangle, &point));
            let [found, other] = [&truth, &strips].map(|t| t.irradiance.watts_per_square_metre());
            let bounds = [&truth, &strips].map(|t| t.bound.watts_per_square_metre());
            prop_assert!((found - other).abs() <= bounds[0] + bounds[1], "{truth:?} {strips:?}");
            prop_assert!(bounds[0] < 1e-13 && bounds[1] < 1e-11, "{bounds:?}");
        }

        #[test]
        fn the_flux_is_the_mean_of_the_exitance(e in coefficients(), (a, b) in (0.01..2.0, 0.01..2.0)) {
            let rectangle = Rectangle::new(DVec3::ONE, DVec3::X * a, DVec3::Z * b).unwrap();
            let sum = gauss_10(0.0, 0.5 * a, |s| {
                gauss_10(0.0, 0.5 * b, |t| {
                    e.at_position(&rectangle, DVec3::ONE + DVec3::X * s + DVec3::Z * t).watts_per_square_metre()
                })
            });
            prop_assert!((e.flux(&rectangle).watts() - sum).abs() < 1e-14);
        }
    }
}
