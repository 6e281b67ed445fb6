//! The pattern in a cup: a half cylinder that mirrors a slanting beam onto its floor.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_6, PI, TAU};

use smallvec::SmallVec;

use super::caustic::{Arrival, ON_CAUSTIC};
use super::{Bounded, OpticsError, ROUNDINGS, length, place, stretch};
use crate::number::{Number, Wide};
use crate::oracle::quadrature::rule::{self, Demand, Ends};
use crate::oracle::trigonometric::Trigonometric;

/// The wall x = R cos t, y = R sin t, |t| < π/2, upright on the floor and mirroring inwards, in a beam that comes along +x and
/// downwards at some elevation. Light once reflected, on the floor, over the direct light there (E₀ × sin elevation).
///
/// A ray that meets the wall at t goes on towards (−cos 2t, −sin 2t), and how high it met the wall tells how far it comes: the
/// floor gets the flux R cos t dt ds of it, s along the way. So
///
/// ```text
/// x sin 2t − y cos 2t = R sin t,  s = R cos t − x cos 2t − y sin 2t > 0
/// E/E_direct = Σ R cos t/|2x cos 2t + 2y sin 2t − R cos t|
/// ```
///
/// whatever the elevation is. The map folds along a nephroid, x = R (3 cos t − cos 3t)/4, y = R (3 sin t − sin 3t)/4, with its
/// cusp at (R/2, 0). All rays are found: the first line is a trigonometric polynomial of degree two.
///
/// First reflection only: light that meets the wall again is out, and so is what lies beyond the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CylinderMirror {
    radius: f64,
    reach: f64,
}

impl CylinderMirror {
    /// - `radius` R: metres, finite, > 0
    /// - `reach`: wall height over the tangent of the elevation, metres, > 0: how far from the wall its upper edge's light
    ///   lands; infinite for a wall that is high enough for all of the floor
    pub fn new(radius: f64, reach: f64) -> Result<CylinderMirror, OpticsError> {
        if reach != f64::INFINITY {
            length("the reach", reach)?;
        }
        Ok(CylinderMirror { radius: length("the cylinder's radius", radius)?, reach })
    }

    /// A point of the caustic, metres: where the light from the wall at the angle t is densest.
    ///
    /// - `t`: radians, in [−π/2, π/2]
    pub fn nephroid(&self, t: f64) -> [f64; 2] {
        let quarter = 0.25 * self.radius;
        [quarter * (3.0 * t.cos() - (3.0 * t).cos()), quarter * (3.0 * t.sin() - (3.0 * t).sin())]
    }

    /// How far from the wall the light from t lands at most: to the wall's other side, or through its open half to the reach.
    fn farthest(&self, t: f64) -> f64 {
        if leaves(t) { self.reach } else { self.reach.min(2.0 * self.radius * t.cos()) }
    }

    /// x sin 2t − y cos 2t − R sin t, as a polynomial in t + π: what wraps around lies where no wall is.
    fn off_ray(&self, x: f64, y: f64) -> Trigonometric {
        Trigonometric { b1: self.radius, a2: -y, b2: x, ..Trigonometric::ZERO }
    }

    /// What arrives on the floor, over the direct light there.
    ///
    /// - `x`, `y`: metres from the cylinder's axis, finite
    /// - error: `bound`, in general 10⁻¹⁴ relative, for the place as given
    /// - source: the lines above; table `caustic_nephroid`
    pub fn at(&self, x: f64, y: f64) -> Result<Arrival, OpticsError> {
        let (x, y) = (place("x", x)?, place("y", y)?);
        let radius = self.radius;
        let is_lit = |t: f64, s: f64| t.abs() < FRAC_PI_2 && s > 0.0 && s <= self.farthest(t);
        let way = |t: f64| {
            let (sin, cos) = (2.0 * t).sin_cos();
            radius * t.cos() - x * cos - y * sin
        };
        // Where the distance from the rays has an extreme near zero, two of them run together.
        let extremes = Trigonometric { a1: radius, a2: 2.0 * x, b2: 2.0 * y, ..Trigonometric::ZERO };
        for tau in extremes.roots().as_slice() {
            let t = tau - PI;
            let (sin, cos) = (2.0 * t).sin_cos();
            let off = x * sin - y * cos - radius * t.sin();
            if is_lit(t, way(t)) && off.abs() <= ON_CAUSTIC * radius {
                return Ok(Arrival::OnCaustic);
            }
        }
        let mut rays: SmallVec<[Wide; 4]> = SmallVec::new();
        for tau in self.off_ray(x, y).roots().as_slice() {
            let t = self.polished(x, y, tau - PI);
            let is_known = rays.iter().any(|known| (*known - t).narrow().abs() <= 1e-14);
            if is_lit(t.narrow(), way(t.narrow())) && !is_known {
                rays.push(t);
            }
        }
        let (mut value, mut bound) = (0.0, 0.0);
        for t in &rays {
            let (flux, slope, bend) = self.slope(x, y, *t);
            let term = (flux / slope).narrow().abs();
            let steep = (slope.narrow() / radius).abs();
            value += term;
            bound += term * (ROUNDINGS * f64::EPSILON + 1e-28 * (1.0 + (bend / radius).abs() / steep) / steep);
        }
        if value.is_finite() && bound.is_finite() {
            Ok(Arrival::Finite { value, bound, n_rays: rays.len() })
        } else {
            Ok(Arrival::OnCaustic)
        }
    }

    /// R cos t, and the first two derivatives of the distance from the ray.
    fn slope(&self, x: f64, y: f64, t: Wide) -> (Wide, Wide, f64) {
        let (sin, cos) = t.sin_cos();
        let (sin_two, cos_two) = (sin * cos * 2.0, Wide::ONE - sin.square() * 2.0);
        let flux = cos * self.radius;
        let slope = (cos_two * x + sin_two * y) * 2.0 - flux;
        let bend = (cos_two * y - sin_two * x) * 4.0 + sin * self.radius;
        (flux, slope, bend.narrow())
    }

    /// A root to the last bits of a [`Wide`].
    fn polished(&self, x: f64, y: f64, start: f64) -> Wide {
        let mut t = Wide::from(start);
        let mut last = f64::INFINITY;
        for _ in 0..12 {
            let (sin, cos) = t.sin_cos();
            let (sin_two, cos_two) = (sin * cos * 2.0, Wide::ONE - sin.square() * 2.0);
            let off = sin_two * x - cos_two * y - sin * self.radius;
            let step = off / self.slope(x, y, t).1;
            let size = step.narrow().abs();
            // Next to a fold the first steps may be long; none is so long that it leads to another ray.
            if !size.is_finite() || size > 0.1 || (size >= last && size < 1e-20) {
                break;
            }
            t = t - step;
            last = size;
            if size < 1e-30 {
                break;
            }
        }
        t
    }

    /// Power that lands in a rectangle of the floor, over the direct irradiance: finite everywhere.
    ///
    /// ```text
    /// P/E_direct = ∫ R cos t L(t) dt,   L(t) the length within the rectangle of the way of the light from t
    /// ```
    ///
    /// - `x`, `y`: its sides' coordinates, metres, finite, each in order
    /// - returns m²; over the rectangle's area it is the mean of [`CylinderMirror::at`]
    /// - error: `bound`, from the rule of quadrature; in general below 10⁻¹⁴ R times the rectangle's diameter
    /// - source: flux is kept; between the angles where a ray meets a corner, or begins or ends on a side, the integrand is
    ///   analytic. Second witness: quadrature of [`CylinderMirror::at`]
    pub fn power_in_rectangle(&self, x: [f64; 2], y: [f64; 2]) -> Result<Bounded, OpticsError> {
        let ([x, y], radius) = ([stretch("x", x)?, stretch("y", y)?], self.radius);
        for [_, to] in [x, y] {
            place("a side", to)?;
        }
        let mut breaks: Vec<f64> = vec![-FRAC_PI_2, -FRAC_PI_6, FRAC_PI_6, FRAC_PI_2];
        for x in x {
            for y in y {
                breaks.extend(self.off_ray(x, y).roots().as_slice().iter().map(|tau| tau - PI));
            }
        }
        // Rays that begin on a side, and that end on one: on the wall again at the angle 3t + π, or at the reach.
        for x in x {
            let angle = (x / radius).acos();
            breaks.extend([angle, -angle]);
            let angle = (-x / radius).acos();
            breaks.extend((-1..=1).flat_map(|turn| [angle, -angle].map(|a| (a + f64::from(turn) * TAU) / 3.0)));
        }
        for y in y {
            breaks.push((y / radius).asin());
            let angle = (-y / radius).asin();
            breaks.extend((-1..=1).flat_map(|turn| [angle, PI - angle].map(|a| (a + f64::from(turn) * TAU) / 3.0)));
        }
        if self.reach.is_finite() {
            let (a1, a2) = (-radius, -self.reach);
            let ends_on_x = x.map(|x| Trigonometric { a0: -x, a1, a2, ..Trigonometric::ZERO });
            let ends_on_y = y.map(|y| Trigonometric { a0: -y, b1: a1, b2: a2, ..Trigonometric::ZERO });
            for side in ends_on_x.iter().chain(&ends_on_y) {
                breaks.extend(side.roots().as_slice().iter().map(|tau| tau - PI));
            }
            // Where the reach ends on the wall.
            let angle = (0.5 * self.reach / radius).acos();
            breaks.extend([angle, -angle]);
        }
        breaks.retain(|t| t.abs() <= FRAC_PI_2);
        breaks.sort_by(f64::total_cmp);
        breaks.dedup_by(|b, a| *b - *a <= 4.0 * f64::EPSILON);
        // The length of a way is a difference of coordinates: its rounding, integrated alike, is what no panel is asked to beat.
        let rounding = 8.0 * f64::EPSILON * (radius + x.iter().chain(&y).fold(0.0, |sum: f64, c| sum.max(c.abs())));
        let integrand = |t: f64| {
            let flux = radius * t.cos();
            [flux * self.within(t, [x, y]), flux * rounding]
        };
        let mut sum = Bounded::default();
        for pair in breaks.windows(2) {
            // Nothing lands from here, or all along.
            let probes = [0.137, 0.5, 0.881].map(|share| self.within(pair[0] + share * (pair[1] - pair[0]), [x, y]));
            if probes == [0.0; 3] {
                continue;
            }
            let demand = |sum: &[f64; 2]| Demand {
                goal: [1e-15 * sum[0].abs() + sum[1], f64::INFINITY],
                floor: |value| [1e-16 * value[0].abs() + value[1], f64::INFINITY],
            };
            let found = rule::integrate(pair, Ends::Smooth, 1e-14, 400, integrand, demand);
            sum.value += found.value[0];
            sum.bound += found.error[0] + found.value[1] + Bounded::rounded(found.value[0]).bound;
        }
        Ok(sum)
    }

    /// How much of the way of the light from t lies in a rectangle, metres.
    fn within(&self, t: f64, sides: [[f64; 2]; 2]) -> f64 {
        let (sin, cos) = t.sin_cos();
        let start = [self.radius * cos, self.radius * sin];
        let towards = [(sin - cos) * (sin + cos), -2.0 * sin * cos];
        let (mut from, mut to) = (0.0_f64, self.farthest(t));
        for ((start, towards), [low, high]) in start.into_iter().zip(towards).zip(sides) {
            if towards == 0.0 {
                if start <= low || start >= high {
                    return 0.0;
                }
                continue;
            }
            let (a, b) = ((low - start) / towards, (high - start) / towards);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (to - from).max(0.0)
    }
}

/// Whether the light from t passes through the open half of the cylinder: it leaves the circle at 3t + π.
fn leaves(t: f64) -> bool {
    t.abs() < FRAC_PI_6
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    const CUP: CylinderMirror = CylinderMirror { radius: 1.0, reach: f64::INFINITY };

    fn value(x: f64, y: f64) -> f64 {
        CUP.at(x, y).unwrap().value().expect("no caustic there")
    }

    #[test]
    fn the_nephroid_is_where_light_has_no_bound() {
        for i in -15..=15 {
            let t = 0.1 * f64::from(i) + 0.003;
            let [x, y] = CUP.nephroid(t);
            assert_eq!(CUP.at(x, y).unwrap(), Arrival::OnCaustic, "t = {t}");
            assert!(value(x - 1e-6, y).max(value(x + 1e-6, y)) > 50.0, "t = {t}");
        }
        assert_eq!(CUP.at(0.5, 0.0).unwrap(), Arrival::OnCaustic);
    }

    /// On the axis of the cup, by hand: t = 0 with E = R/|2x − R|, and beyond the cusp the pair cos t = R/2x.
    #[test]
    fn on_the_middle_line_it_is_arithmetic() {
        assert_relative_eq!(value(0.25, 0.0), 2.0, max_relative = 1e-15);
        assert_relative_eq!(value(-3.0, 0.0), 1.0 / 7.0, max_relative = 1e-15);
        let x = 0.75;
        let cos: f64 = 0.5 / x;
        let pair = cos / (2.0 * x * (2.0 * cos * cos - 1.0) + 0.0 - cos).abs();
        assert_relative_eq!(value(x, 0.0), 1.0 / (2.0 * x - 1.0) + 2.0 * pair, max_relative = 1e-14);
    }

    #[test]
    fn beyond_the_wall_it_is_dark() {
        for (x, y) in [(1.1, 0.0), (0.8, 0.7), (0.3, -1.0), (-0.2, 3.0), (1e9, 1e9)] {
            assert_eq!(CUP.at(x, y).unwrap(), Arrival::Finite { value: 0.0, bound: 0.0, n_rays: 0 }, "{x}, {y}");
        }
        // A low wall's light ends before the middle.
        let low = CylinderMirror::new(1.0, 0.5).unwrap();
        assert_eq!(low.at(0.25, 0.0).unwrap().value(), Some(0.0));
        assert_relative_eq!(low.at(0.75, 0.0).unwrap().value().unwrap(), 2.0 + 0.0, max_relative = 1e-12);
    }

    /// Away from the caustic: by two nested Gauss rules of the point value.
    #[test]
    fn rectangles_hold_what_the_irradiance_adds_up_to() {
        for ([x0, x1], [y0, y1]) in
            [([-0.5, -0.1], [-0.3, 0.2]), ([-2.0, -1.5], [-0.2, 0.4]), ([0.58, 0.62], [-0.01, 0.01])]
        {
            let inner = |x: f64| crate::number::gauss_10(0.5 * (y0 + y1), 0.5 * (y1 - y0), |y| value(x, y));
            let wanted = crate::number::gauss_10(0.5 * (x0 + x1), 0.5 * (x1 - x0), inner);
            let found = CUP.power_in_rectangle([x0, x1], [y0, y1]).unwrap();
            assert_relative_eq!(found.value, wanted, max_relative = 1e-8);
            assert!(found.bound <= 1e-12 * found.value, "{found:?}");
        }
    }

    /// All that the wall receives lands on the floor below the chords, or leaves: ∫ R cos t 2R cos t dt = π R².
    #[test]
    fn the_floor_gets_what_the_wall_got() {
        let inside: f64 = CUP.power_in_rectangle([-1.0, 1.0], [-1.0, 1.0]).unwrap().value;
        // Light that has left the cup lies in its own part of the square: x < 0 beyond the circle.
        assert!(inside > PI && inside < PI + 0.25, "{inside}");
        // A reach of R: what lands is ∫ R cos t min(R, 2 R cos t) dt, over |t| ≤ π/3 R cos t R, beyond it 2 R² cos² t.
        let low = CylinderMirror::new(1.0, 1.0).unwrap();
        let whole = low.power_in_rectangle([-2.0, 2.0], [-2.0, 2.0]).unwrap();
        let third = PI / 3.0;
        let beyond = (PI - 2.0 * third) - (2.0 * third).sin();
        assert_relative_eq!(whole.value, 2.0 * third.sin() + beyond, max_relative = 1e-13);
    }

    #[test]
    fn tiles_add_up_over_the_caustic() {
        for mirror in [CUP, CylinderMirror::new(1.0, 0.8).unwrap()] {
            let cuts = [-1.2, -0.4, 0.1, 0.5, 0.6, 1.05];
            let whole = mirror.power_in_rectangle([cuts[0], cuts[5]], [cuts[0], cuts[5]]).unwrap();
            let mut sum = 0.0;
            for x in cuts.windows(2) {
                for y in cuts.windows(2) {
                    sum += mirror.power_in_rectangle([x[0], x[1]], [y[0], y[1]]).unwrap().value;
                }
            }
            assert_relative_eq!(sum, whole.value, max_relative = 1e-13);
            assert!(whole.bound < 1e-13);
        }
    }

    proptest! {
        #[test]
        fn the_pattern_has_a_mirror_line_and_no_scale(x in -1.5..1.0, y in 0.0..1.0, scale in 0.1..10.0) {
            let larger = CylinderMirror::new(scale, f64::INFINITY).unwrap();
            match [CUP.at(x, y).unwrap(), CUP.at(x, -y).unwrap(), larger.at(x * scale, y * scale).unwrap()] {
                [Arrival::Finite { value: a, bound, n_rays }, Arrival::Finite { value: b, .. }, Arrival::Finite { value: c, .. }] => {
                    prop_assert!(a.is_finite() && bound <= 1e-9 * a && n_rays <= 4);
                    prop_assert!((a - b).abs() <= 1e-13 * a);
                    // The scaled place is rounded: next to a caustic that tells.
                    prop_assert!((a - c).abs() <= 1e-9 * a * (1.0 + a * a));
                }
                [a, b, _] => prop_assert_eq!(a, b),
            }
        }
    }

    #[test]
    fn what_is_no_cup_is_refused() {
        assert!(matches!(CylinderMirror::new(0.0, 1.0), Err(OpticsError::Length { .. })));
        assert!(CylinderMirror::new(1.0, f64::NAN).is_err() && CylinderMirror::new(1.0, -1.0).is_err());
        assert!(CUP.at(f64::NAN, 0.0).is_err() && CUP.at(0.0, f64::INFINITY).is_err());
        assert!(CUP.power_in_rectangle([1.0, 0.0], [0.0, 1.0]).is_err());
    }
}
