//! Form factors of whole sources that nothing hides, in forms that keep their digits where the contour sum cancels.

use std::f64::consts::PI;

use glam::DVec3;

use super::body::Flat;
use super::piece::{Curve, Piece};
use super::rim::{Rim, Term};

/// A form factor and a bound on its error; pure numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Factor {
    pub value: f64,
    pub bound: f64,
}

/// Rounding steps behind a result, in units of `f64::EPSILON`: each formula below has fewer.
const STEPS: f64 = 16.0;

/// Form factor from a point to a disk wholly above its horizon, any pose.
///
/// The full turn of the rim's contour integral, where only I0 and I1 remain (symbols of [`Rim::contour`]):
///
/// ```text
/// F = a² (n_w N + 2 c_u c_w n_u) / ((P + D) D),
/// N = D − E, E = (c_u − a)(c_u + a) − c_w²;  where E > 0, without cancellation, N = 4 c_u² c_w²/(D + E)
/// ```
///
/// Coaxial and parallel it is a²/(h² + a²).
///
/// - `n`: the receiver's unit normal; `rim`: relative to the receiver, n · r ≥ 0 all along it
/// - error: 4·10⁻¹⁶ relative, times the conditioning of the height over the plane and of the distance to the rim
pub(super) fn disk(n: DVec3, rim: &Rim) -> Factor {
    let (a, cw, cu) = (rim.radius, rim.height, rim.offset);
    let (nu, nw) = (n.dot(rim.u), n.dot(rim.axis));
    let near = cw.hypot(cu - a);
    let p = cw * cw + cu * cu + a * a;
    let d = near * cw.hypot(cu + a);
    let e = (cu - a) * (cu + a) - cw * cw;
    let big_n = if e <= 0.0 { d - e } else { 4.0 * cu * cu * cw * cw / (d + e) };
    let scale = a * a / ((p + d) * d);
    let (level, tilted) = (nw * big_n, 2.0 * cu * cw * nu);
    let condition = 1.0 + (cu + cw) / cw + (cu + a) / near;
    Factor {
        value: scale * (level + tilted),
        bound: STEPS * f64::EPSILON * scale * (level.abs() + tilted.abs()) * condition,
    }
}

/// Form factor from a point to a sphere, horizon included.
///
/// With s = R/d the sine of its half-angle, q = √(1 − s²), c the cosine between the receiver's normal and the direction of
/// the centre, z = √(1 − c²), y = √(1 − c²/s²), γ = atan2(y, −q c/s):
///
/// ```text
/// F = s² c                                        for c ≥ s   (all of it above the horizon)
/// F = (γ s² c − s q y + asin(s y/z))/π            for |c| < s
/// F = 0                                           for c ≤ −s
/// ```
///
/// - error: a few ulp, of F where all is above the horizon, of s otherwise
/// - source: the projected area of a spherical cap on the unit hemisphere, cut by its equator
pub(super) fn sphere(n: DVec3, center: DVec3, radius: f64) -> Factor {
    let distance = center.length();
    let s = radius / distance;
    let c = n.dot(center) / distance;
    if c >= s {
        Factor { value: s * s * c, bound: STEPS * f64::EPSILON * s * s }
    } else if c <= -s {
        Factor::default()
    } else {
        let q = ((distance - radius) * (distance + radius)).sqrt() / distance;
        let z = n.cross(center).length() / distance;
        let y = ((s - c) * (s + c)).sqrt() / s;
        let gamma = y.atan2(-q * c / s);
        let value = (gamma * s * s * c - s * q * y + (s * y / z).min(1.0).asin()) / PI;
        Factor { value: value.max(0.0), bound: STEPS * f64::EPSILON * s / q }
    }
}

/// Form factor of the directions of a piece: the sum over its boundary, divided by 2π.
///
/// - error: absolute, from the sizes of what is added; a small source keeps fewer relative digits
pub(super) fn contour(n: DVec3, piece: &Piece) -> Factor {
    let mut sum = Term::default();
    for curve in &piece.curves {
        let (from, to) = curve.range();
        sum += curve.contour(n, from, to);
    }
    from_terms(sum)
}

/// A contour sum as a form factor.
pub(super) fn from_terms(sum: Term) -> Factor {
    Factor { value: sum.value / (2.0 * PI), bound: STEPS * f64::EPSILON * sum.weight / (2.0 * PI) }
}

/// Seen smaller than this (radius over distance), a flat figure is integrated by a product rule without cancellation.
pub(super) const SMALL: f64 = 0.05;

/// Form factor from a point to a small or far flat figure wholly above its horizon: the defining integral
/// ∫ cosθᵢ cosθₛ/(π r²) dA over the signed triangles between `center` and the edges, by an 8 × 8 Gauss product rule.
///
/// The contour sum adds terms of the size of the angle to a result of the size of its square; this adds areas. Within
/// [`SMALL`] the integrand is so smooth that the rule's own error lies below rounding (2·10⁻¹⁷ relative).
///
/// - `center`: a point of the figure's plane near its middle, relative to the receiver
/// - `middle`: the same as an offset of the figure
pub(super) fn small_flat(n: DVec3, shape: &Flat, center: DVec3, middle: DVec3) -> Factor {
    let height = center.dot(shape.normal).abs();
    let (mut sum, mut size) = (0.0, 0.0);
    for [i, j] in &shape.edges {
        let (p, q) = (shape.offsets[*i as usize] - middle, shape.offsets[*j as usize] - middle);
        let area = 0.5 * p.cross(q).dot(shape.normal);
        let mut mean = 0.0;
        for (s, weight_s) in GAUSS_8 {
            let mut line = 0.0;
            for (t, weight_t) in GAUSS_8 {
                let r = center + (p + (q - p) * t) * s;
                let square = r.length_squared();
                line += weight_t * n.dot(r) / (square * square);
            }
            mean += weight_s * 2.0 * s * line;
        }
        sum += area * mean;
        size += area.abs() * mean.abs();
    }
    let lift = n.dot(center);
    let condition = 1.0 + center.length() * (1.0 / height + 1.0 / lift);
    Factor { value: height / PI * sum, bound: STEPS * f64::EPSILON * height / PI * size * condition }
}

/// Gauss–Legendre nodes and weights on [0, 1], order 8 (Abramowitz and Stegun, table 25.4, halved).
const GAUSS_8: [(f64, f64); 8] = [
    (0.5 - 0.5 * 0.960_289_856_497_536_3, 0.5 * 0.101_228_536_290_376_26),
    (0.5 - 0.5 * 0.796_666_477_413_626_7, 0.5 * 0.222_381_034_453_374_48),
    (0.5 - 0.5 * 0.525_532_409_916_329, 0.5 * 0.313_706_645_877_887_3),
    (0.5 - 0.5 * 0.183_434_642_495_649_8, 0.5 * 0.362_683_783_378_362),
    (0.5 + 0.5 * 0.183_434_642_495_649_8, 0.5 * 0.362_683_783_378_362),
    (0.5 + 0.5 * 0.525_532_409_916_329, 0.5 * 0.313_706_645_877_887_3),
    (0.5 + 0.5 * 0.796_666_477_413_626_7, 0.5 * 0.222_381_034_453_374_48),
    (0.5 + 0.5 * 0.960_289_856_497_536_3, 0.5 * 0.101_228_536_290_376_26),
];

/// The only curve of a whole disk.
pub(super) fn whole_rim(piece: &Piece) -> Option<&Rim> {
    match piece.curves.as_slice() {
        [Curve::Round { rim, .. }] if !piece.is_cut => Some(rim),
        _ => None,
    }
}
