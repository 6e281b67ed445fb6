//! Form factors of whole sources that nothing hides, in forms that keep their digits where the contour sum cancels.

use std::f64::consts::PI;

use super::form::{FlatForm, Form};
use super::piece::{Curve, Piece};
use super::rim::{Rim, Term};
use crate::number::{GAUSS_8, Number, Vector};

/// A form factor and a bound on the error of its `f64`; pure numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factor<T = f64> {
    pub value: T,
    pub bound: f64,
}

impl<T: Number> Factor<T> {
    pub fn nothing() -> Factor<T> {
        Factor { value: T::zero(), bound: 0.0 }
    }
    fn positive(self) -> Factor<T> {
        if self.value.primal() < 0.0 { Factor { value: T::zero(), ..self } } else { self }
    }
}

/// Rounding steps behind a result, in units of `f64::EPSILON`: each formula below has fewer.
const STEPS: f64 = 16.0;

/// Form factor from a point to what is above its horizon of a source that nothing hides.
///
/// - `piece`: the form's part above the horizon
/// - `n`: the receiver's unit normal
pub(super) fn unoccluded<T: Number>(form: &Form<T>, piece: &Piece<T>, n: Vector<T>) -> Factor<T> {
    match form {
        Form::Ball { center, radius } => sphere(n, *center, *radius),
        Form::Disk { .. } => match whole_rim(piece) {
            Some(rim) => disk(n, rim),
            None => contour(n, piece).positive(),
        },
        Form::Mesh(_) => contour(n, piece).positive(),
        Form::Flat(flat) => {
            let is_small = flat.reach < SMALL * flat.center.primal().length();
            if is_small && !piece.is_cut && !T::CANCELS_FREELY {
                small_flat(n, flat)
            } else {
                contour(n, piece).positive()
            }
        }
    }
}

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
fn disk<T: Number>(n: Vector<T>, rim: &Rim<T>) -> Factor<T> {
    let (a, cw, cu) = (rim.radius, rim.height, rim.offset);
    let nw = n.dot(rim.axis);
    let lateral = cu * n.dot(rim.u) + rim.aside * n.dot(rim.v);
    let near = cw.hypot(cu - a);
    let p = cw * cw + cu * cu + a * a;
    let d = near * cw.hypot(cu + a);
    let e = (cu - a) * (cu + a) - cw * cw;
    let big_n = if e.primal() <= 0.0 { d - e } else { cu * cu * cw * cw * 4.0 / (d + e) };
    let scale = a * a / ((p + d) * d);
    let (level, tilted) = (nw * big_n, cw * lateral * 2.0);
    let value = scale * (level + tilted);
    let size = |x: T| x.primal().abs();
    let condition = 1.0 + size(cu + cw) / size(cw) + size(cu + a) / size(near);
    Factor { value, bound: STEPS * f64::EPSILON * size(scale) * (size(level) + size(tilted)) * condition }
}

/// Form factor from a point to a sphere, horizon included.
///
/// With s = R/d the sine of its half-angle, q = √(1 − s²), c the cosine between the receiver's normal and the direction of
/// the centre, y = √(1 − c²/s²), γ = atan2(y, −q c/s):
///
/// ```text
/// F = s² c                                        for c ≥ s   (all of it above the horizon)
/// F = (γ s² c − s q y + atan2(s y, q))/π           for |c| < s
/// F = 0                                           for c ≤ −s
/// ```
///
/// - error: a few ulp, of F where all is above the horizon, of s otherwise
/// - source: the projected area of a spherical cap on the unit hemisphere, cut by its equator
fn sphere<T: Number>(n: Vector<T>, center: Vector<T>, radius: T) -> Factor<T> {
    let distance = center.length();
    let s = radius / distance;
    let c = n.dot(center) / distance;
    let sine = s.primal();
    if c.primal() >= sine {
        Factor { value: s * s * c, bound: STEPS * f64::EPSILON * sine * sine }
    } else if c.primal() <= -sine {
        Factor::nothing()
    } else {
        let q = ((distance - radius) * (distance + radius)).sqrt() / distance;
        let y = ((s - c) * (s + c)).sqrt() / s;
        let gamma = y.atan2(-q * c / s);
        // asin(s y/z) with its cosine: z² − s² y² = z² − s² + c² = q², exactly.
        let cap = (s * y).atan2(q);
        let value = (gamma * s * s * c - s * q * y + cap) / (T::turn() * 0.5);
        Factor { value, bound: STEPS * f64::EPSILON * sine / q.primal() }.positive()
    }
}

/// Form factor of the directions of a piece: the sum over its boundary, divided by 2π.
///
/// - error: absolute, from the sizes of what is added; a small source keeps fewer relative digits
fn contour<T: Number>(n: Vector<T>, piece: &Piece<T>) -> Factor<T> {
    let mut sum = Term::default();
    for curve in &piece.curves {
        let (from, to) = curve.range();
        sum += curve.contour(n, from, to);
    }
    from_terms(sum)
}

/// A contour sum as a form factor.
pub(super) fn from_terms<T: Number>(sum: Term<T>) -> Factor<T> {
    let value = sum.value / T::turn();
    Factor { value, bound: f64::EPSILON * (STEPS * sum.weight + sum.rounding_of_sum()) / (2.0 * PI) }
}

/// Seen smaller than this (radius over distance), a flat figure is integrated by a product rule without cancellation.
const SMALL: f64 = 0.05;

/// Form factor from a point to a small or far flat figure wholly above its horizon: the defining integral
/// ∫ cosθᵢ cosθₛ/(π r²) dA over the signed triangles between its middle and the edges, by an 8 × 8 Gauss product rule.
///
/// The contour sum adds terms of the size of the angle to a result of the size of its square; this adds areas. Within
/// [`SMALL`] the integrand is so smooth that the rule's own error lies below rounding (2·10⁻¹⁷ relative).
fn small_flat<T: Number>(n: Vector<T>, flat: &FlatForm<T>) -> Factor<T> {
    let center = flat.center;
    let (mut sum, mut size) = (T::zero(), 0.0);
    for [i, j] in &flat.shape.edges {
        let (i, j) = (*i as usize, *j as usize);
        let (p, line) = (flat.beside_middle(i), flat.line(i, j));
        // Twice the vector area, times r: the same for all r of the triangle's plane.
        let facing = p.cross(line).dot(center);
        let mut mean = T::zero();
        for (s, weight_s) in GAUSS_8 {
            let mut along = T::zero();
            for (t, weight_t) in GAUSS_8 {
                let r = center + (p + line * T::constant(t)) * T::constant(s);
                let square = r.length_squared();
                along = along + n.dot(r) / (square * square) * weight_t;
            }
            mean = mean + along * (weight_s * s);
        }
        sum = sum + facing * mean;
        size += (facing * mean).primal().abs();
    }
    let (height, lift) = (center.dot(flat.normal).primal().abs(), n.dot(center).primal());
    let condition = 1.0 + center.primal().length() * (1.0 / height + 1.0 / lift);
    let value = sum.abs() / (T::turn() * 0.5);
    Factor { value, bound: STEPS * f64::EPSILON / PI * size * condition }
}

/// The only curve of a whole disk.
fn whole_rim<T>(piece: &Piece<T>) -> Option<&Rim<T>> {
    match piece.curves.as_slice() {
        [Curve::Round { rim, .. }] if !piece.is_cut => Some(rim),
        _ => None,
    }
}
