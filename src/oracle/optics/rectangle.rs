//! What lands in a rectangle of light that has an axis.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use smallvec::SmallVec;

use super::Bounded;
use super::fan::{self, Fan, Knot};
use crate::number::Wide;
use crate::oracle::quadrature::rule::{self, Demand, Ends};

/// Relative to what lands on the circles that the rectangle meets.
const DEMANDED: f64 = 2e-14;
/// Rounding of an arc's angle, over a whole turn: no panel is asked for more.
const NOISE: f64 = 4e-15;
const MOST_PANELS: usize = 600;

/// ∫ α(|f|) g T dt over all rays; between the rays whose circles touch a side or meet a corner, and the map's folds, the
/// integrand is analytic, with square roots at such ends.
pub(super) fn power<F: Fan>(fan: &F, knots: &[Knot], is_point: bool, sides: [[f64; 2]; 2]) -> Bounded {
    let arc = |radius: f64| angle_within(radius, sides);
    if is_point {
        // A point on a side or a corner is half or a quarter inside: what vanishing circles around it tell.
        let landed = fan.flux(fan.last()).narrow() * fan.share(0.0);
        let smallest = sides.iter().flatten().map(|c| c.abs()).filter(|c| *c > 0.0).fold(1.0, f64::min);
        return Bounded::rounded(landed * arc(0.5 * smallest));
    }
    let [x, y] = sides;
    let mut radii: SmallVec<[f64; 9]> = x.iter().chain(&y).map(|c| c.abs()).collect();
    radii.extend(x.iter().flat_map(|x| y.iter().map(|y| x.hypot(*y))));
    radii.sort_by(f64::total_cmp);
    radii.dedup();
    let last = knots[knots.len() - 1].u.narrow();
    let mut breaks: Vec<f64> = knots.iter().map(|knot| knot.u.narrow()).collect();
    for radius in radii {
        breaks.extend(fan::preimages(fan, knots, radius, Wide::narrow));
    }
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|b, a| *b - *a <= 4.0 * f64::EPSILON * last);
    let mut sum = Bounded::default();
    for pair in breaks.windows(2) {
        let middle = 0.5 * (pair[0] + pair[1]);
        let at_middle = arc(fan.landing(middle).abs());
        if at_middle == 0.0 {
            continue;
        }
        let integrand = |u: f64| {
            let (_, flux_slope) = fan::jet(|u| fan.flux(u), u);
            let weight = flux_slope * fan.share(u);
            [weight * arc(fan.landing(u).abs()), weight * TAU]
        };
        let demand = |sum: &[f64; 2]| Demand {
            goal: [DEMANDED * sum[1].abs(), f64::INFINITY],
            floor: |value| [NOISE * value[1].abs(), f64::INFINITY],
        };
        let found = rule::integrate(pair, Ends::Roots, 1e-15 * last, MOST_PANELS, integrand, demand);
        sum.value += found.value[0];
        sum.bound += found.error[0] + 1e-15 * found.value[1].abs();
    }
    sum
}

/// The angle under which a circle around the origin lies in a rectangle, radians.
///
/// - `radius`: > 0 (a vanishing circle tells how much of the origin's surroundings is inside)
pub(super) fn angle_within(radius: f64, [x, y]: [[f64; 2]; 2]) -> f64 {
    let mut angles: SmallVec<[f64; 10]> = SmallVec::new();
    let aside = |c: f64| ((radius - c) * (radius + c)).sqrt();
    for c in x {
        if c.abs() < radius {
            let angle = aside(c).atan2(c);
            angles.extend([angle, TAU - angle]);
        }
    }
    for c in y {
        if c.abs() < radius {
            let angle = c.atan2(aside(c));
            angles.extend([if angle < 0.0 { angle + TAU } else { angle }, PI - angle]);
        }
    }
    let is_within = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let (px, py) = (radius * cos, radius * sin);
        px > x[0] && px < x[1] && py > y[0] && py < y[1]
    };
    if angles.is_empty() {
        return if is_within(0.123 * FRAC_PI_2) { TAU } else { 0.0 };
    }
    angles.sort_by(f64::total_cmp);
    let first = angles[0];
    angles.push(first + TAU);
    angles.windows(2).map(|pair| if is_within(0.5 * (pair[0] + pair[1])) { pair[1] - pair[0] } else { 0.0 }).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    #[test]
    fn circles_lie_in_rectangles_as_drawn() {
        let unit = [[-1.0, 1.0], [-1.0, 1.0]];
        assert_relative_eq!(angle_within(0.5, unit), TAU, max_relative = 1e-15);
        assert_abs_diff_eq!(angle_within(1.5, unit), 0.0);
        // cos φ ≤ 1/1.2 on both sides of each corner.
        let corner = FRAC_PI_2 - 2.0 * (1.0_f64 / 1.2).acos();
        assert_relative_eq!(angle_within(1.2, unit), 4.0 * corner, max_relative = 1e-14);
        assert_relative_eq!(angle_within(1e-9, [[0.0, 1.0], [0.0, 1.0]]), FRAC_PI_2, max_relative = 1e-14);
        assert_relative_eq!(angle_within(1e-9, [[0.0, 1.0], [-1.0, 1.0]]), PI, max_relative = 1e-14);
        assert_abs_diff_eq!(angle_within(1.0, [[2.0, 3.0], [0.0, 1.0]]), 0.0);
    }

    /// The area of a rectangle is ∫ α ρ dρ.
    #[test]
    fn arcs_add_up_to_the_area() {
        let sides = [[-0.3, 1.1], [0.2, 0.9]];
        let n = 200_000;
        let sum: f64 = (0..n)
            .map(|i| {
                let radius = (f64::from(i) + 0.5) / f64::from(n) * 1.5;
                radius * angle_within(radius, sides) * 1.5 / f64::from(n)
            })
            .sum();
        assert_relative_eq!(sum, 1.4 * 0.7, max_relative = 1e-7);
    }
}
