//! The rim of a disk (or the silhouette of a ball) as a curve of directions, and its contour integral.

use glam::DVec3;

use crate::number::{Number, Vector};

/// A circle around `center`, seen from the origin: `r(t) = center + radius (u cos t + v sin t)`.
///
/// `axis` points away from the origin (`height > 0`), so that growing `t` runs counter-clockwise as seen from it and
/// the disk lies on the side `r × dr`. Along the rim `|r|² = P + Q cos t`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rim<T = f64> {
    pub center: Vector<T>,
    /// Along the centre's offset from the axis foot.
    pub u: Vector<T>,
    pub v: Vector<T>,
    pub axis: Vector<T>,
    pub radius: T,
    /// Of the plane: `center · axis`, > 0.
    pub height: T,
    /// Of the centre from the plane's foot point: `center · u`, ≥ 0.
    pub offset: T,
    /// `center · v`: zero or, where the centre lies on the axis and no direction is its own, the trace that rounding and
    /// slopes leave of it. It is carried to first order.
    pub aside: T,
}

/// A contour term, and the sum of the sizes of what it was added from, weighed by their conditioning: the error of
/// `value` in `f64` is a few `f64::EPSILON · weight`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Term<T = f64> {
    pub value: T,
    pub weight: f64,
    /// Terms that were added.
    pub count: u32,
}

/// From so many terms on the rounding of their sum is told, too: fewer are within what `weight` says.
const MANY: u32 = 256;

impl<T: Number> Default for Term<T> {
    fn default() -> Term<T> {
        Term { value: T::zero(), weight: 0.0, count: 0 }
    }
}

impl<T: Number> Term<T> {
    /// What the sum may be off by beside its terms, in units of rounding: like terms are all rounded alike.
    pub fn rounding_of_sum(&self) -> f64 {
        if self.count < MANY { 0.0 } else { 0.5 * f64::from(self.count) * self.value.primal().abs() }
    }
    /// The same way gone the other way round.
    pub fn backward(self) -> Term<T> {
        Term { value: -self.value, ..self }
    }
}

impl<T: Number> std::ops::AddAssign for Term<T> {
    fn add_assign(&mut self, other: Term<T>) {
        self.value = self.value + other.value;
        self.weight += other.weight;
        self.count += other.count;
    }
}

impl<T: Number> Rim<T> {
    /// The rim of a disk with unit normal `normal` (either side). `None` for a disk seen edge-on: it has no area.
    pub fn of_disk(center: Vector<T>, normal: Vector<T>, radius: T) -> Option<Rim<T>> {
        let along = center.dot(normal);
        let distance = center.primal().length();
        if along.primal().abs() <= EDGE_ON * (distance + radius.primal()) {
            return None;
        }
        let axis = if along.primal() < 0.0 { -normal } else { normal };
        let height = along.abs();
        let sideways = center - axis * height;
        if sideways.primal().length() <= CENTRAL * distance {
            let (u, v) = axis.frame();
            return Some(Rim { center, u, v, axis, radius, height, offset: center.dot(u), aside: center.dot(v) });
        }
        let u = sideways.normalize();
        // Once more: what is left of the axis after one subtraction is large beside a small offset.
        let u = (u - axis * u.dot(axis)).normalize();
        Some(Rim { center, u, v: axis.cross(u), axis, radius, height, offset: center.dot(u), aside: T::zero() })
    }

    /// The circle in which the ball's tangent cone touches it. `None` if the origin is inside or on the ball.
    ///
    /// The circle's centre lies on its axis by construction: measuring that offset would return rounding noise.
    pub fn of_silhouette(center: Vector<T>, radius: T) -> Option<Rim<T>> {
        let distance = center.length();
        if (radius / distance).primal() >= 1.0 {
            return None;
        }
        let axis = center * (T::constant(1.0) / distance);
        let cosine_squared = (distance - radius) * (distance + radius) / (distance * distance);
        let height = distance * cosine_squared;
        let (u, v) = axis.frame();
        Some(Rim {
            center: axis * height,
            u,
            v,
            axis,
            radius: radius * cosine_squared.sqrt(),
            height,
            offset: T::zero(),
            aside: T::zero(),
        })
    }

    /// Whether the axis passes through the centre, as far as rounding can tell.
    pub fn is_central(&self) -> bool {
        self.offset.primal().abs() <= 2.0 * CENTRAL * (self.height.primal() + self.radius.primal())
    }

    pub fn point(&self, t: T) -> Vector<T> {
        self.at(t.sin_cos())
    }

    /// The point at an angle that is given by its (sin, cos).
    pub fn at(&self, (sin, cos): (T, T)) -> Vector<T> {
        self.center + (self.u * cos + self.v * sin) * self.radius
    }

    /// The parameter, in (−π, π], of the rim's point in a direction that meets it.
    pub fn angle(&self, direction: Vector<T>) -> T {
        let hit = direction * (self.height / direction.dot(self.axis));
        (hit.dot(self.v) - self.aside).atan2(hit.dot(self.u) - self.offset)
    }

    /// The parameters `middle − half` and `middle + half` at which `level + plane · (r(t) − center)` vanishes, where it does.
    ///
    /// With G = a hypot(plane·u, plane·v) it is `level + G cos(t − middle)`; `half` = acos(−level/G), by its tangent.
    pub fn roots(&self, plane: Vector<T>, level: T) -> RimRoots<T> {
        let (pu, pv) = (plane.dot(self.u), plane.dot(self.v));
        let swing = self.radius * pu.hypot(pv);
        let root = ((swing - level) * (swing + level)).sqrt();
        RimRoots { middle: pv.atan2(pu), half: root.atan2(-level), swing }
    }

    /// Two ends of the part where `plane · r(t) + k ≥ 0`; `Whole` and `Nothing` where the rim does not cross.
    pub fn cut(&self, plane: Vector<T>, k: T) -> RimCut<T> {
        let level = plane.dot(self.center) + k;
        let RimRoots { middle, half, swing, .. } = self.roots(plane, level);
        let size = self.center.primal().length() + self.radius.primal() + k.primal().abs();
        let noise = 4.0 * f64::EPSILON * size;
        let (level, swing) = (level.primal(), swing.primal());
        // A rim that lies in the plane has nothing before it: this question comes first.
        if level <= noise - swing {
            RimCut::Nothing
        } else if level >= swing - noise {
            RimCut::Whole
        } else {
            RimCut::Part { from: middle - half, to: middle + half }
        }
    }

    /// ∫ n·(r × dr)/|r|² along the rim from `t0` to `t1` (at most one turn), in closed form.
    ///
    /// With a, c_w, c_u radius, height, offset, and n = (n_u, n_v, n_w) in the rim's frame, the integrand is
    /// `a [a n_w + (c_u n_w − c_w n_u) cos t − c_w n_v sin t] / (P + Q cos t)`, where P = c_w² + c_u² + a², Q = 2 a c_u. With
    /// D = √(P² − Q²) and b = Q/(P + D), the identity `atan(k tan(t/2)) = t/2 − ψ(t)`, ψ = atan2(b sin t, 1 + b cos t),
    /// k = (1 − b)/(1 + b), takes the branch out of the half-angle substitution:
    ///
    /// ```text
    /// I0 = ∫ dt/(P + Q cos t)       = (Δt − 2 Δψ)/D
    /// I1 = ∫ cos t dt/(P + Q cos t) = (−b Δt + 2P/(P + D) · Δψ/b)/D
    /// I2 = ∫ sin t dt/(P + Q cos t) = −log1p(Q Δcos/(P + Q cos t0))/Q
    /// ```
    ///
    /// written below so that b → 0 needs no case of its own.
    ///
    /// - error: a few ulp of the sum of the sizes of the three parts, times the distance to the rim's farthest point over
    ///   that to its nearest; both are in `weight`
    pub fn contour(&self, n: Vector<T>, t0: T, t1: T) -> Term<T> {
        let (a, cw, cu) = (self.radius, self.height, self.offset);
        let (nu, nv, nw) = (n.dot(self.u), n.dot(self.v), n.dot(self.axis));
        let near = cw.hypot(cu - a);
        let far = cw.hypot(cu + a);
        let p = cw * cw + cu * cu + a * a;
        let q = a * cu * 2.0;
        let d = near * far;
        let b = q / (p + d);
        let turn = t1 - t0;
        // Of the middle and the half of the turn, from which those of the ends follow, and their difference exactly.
        let (sin_m, cos_m) = ((t0 + t1) * 0.5).sin_cos();
        let (sin_h, cos_h) = (turn * 0.5).sin_cos();
        let (sin0, cos0) = (sin_m * cos_h - cos_m * sin_h, cos_m * cos_h + sin_m * sin_h);
        let (sin1, cos1) = (sin_m * cos_h + cos_m * sin_h, cos_m * cos_h - sin_m * sin_h);
        let psi_over_b = |sin: T, cos: T| {
            let x = sin / (b * cos + 1.0);
            x * atan_ratio(b * x)
        };
        let delta = psi_over_b(sin1, cos1) - psi_over_b(sin0, cos0);
        let share = T::constant(1.0) / d;
        let i0 = (turn - b * delta * 2.0) * share;
        let i1 = (p / (p + d) * delta * 2.0 - b * turn) * share;
        let delta_cos = sin_m * sin_h * -2.0;
        let square = |sin: T, cos: T| cw * cw + (cu + a * cos) * (cu + a * cos) + (a * sin) * (a * sin);
        let start = square(sin0, cos0);
        let i2 = -delta_cos / start * log1p_ratio(q * delta_cos / start);
        let (f0, f1, f2) = (a * a * nw, a * (cu * nw - cw * nu), -a * cw * nv);
        let mut value = f0 * i0 + f1 * i1 + f2 * i2;
        if self.is_central() {
            // ∂/∂c_v at c_u = 0, where |r|² is P all along.
            let odd = -delta_cos;
            let even = (turn - (sin1 * cos1 - sin0 * cos0)) * 0.5;
            let mixed = (sin1 - sin0) * (sin1 + sin0) * 0.5;
            let turned = a * nw * odd - (f0 * odd + f1 * mixed + f2 * even) * a * 2.0 / p;
            value = value + self.aside * turned / p;
        }
        let size = |x: T| x.primal().abs();
        let (turn, delta, b) = (turn.primal(), delta.primal().abs(), b.primal());
        let sizes = size(f0) * (turn + 2.0 * b * delta) / d.primal()
            + size(f1) * (b * turn + 2.0 * delta) / d.primal()
            + size(f2 * i2);
        // The ends are known to the rounding of an angle, whatever the length between them.
        let stop = square(sin1, cos1).primal();
        let ends = (size(f0) + size(f1) + size(f2)) * (size(t0) / start.primal() + size(t1) / stop);
        Term { value, weight: sizes * (far.primal() / near.primal()) + 0.25 * ends, count: 1 }
    }
}

impl Rim {
    /// The parameter, in [0, 2π), of the rim's point in a direction that meets it.
    #[cfg(test)]
    fn parameter(&self, direction: DVec3) -> f64 {
        let t = self.angle(Vector::constant(direction));
        if t < 0.0 { t + std::f64::consts::TAU } else { t }
    }

    /// Signed angle (a sine; lower bound of its size up to the foreshortening at the far side) from the cone's mantle to
    /// a unit direction: positive inside the cone.
    pub fn margin(&self, d: DVec3) -> f64 {
        let d = Vector::constant(d);
        let (du, dv, dw) = (d.dot(self.u), d.dot(self.v), d.dot(self.axis));
        let out = Number::hypot(self.height * du - self.offset * dw, self.height * dv);
        (self.radius * dw - out) / Number::hypot(self.height, self.offset + self.radius)
    }
}

/// See [`Rim::roots`].
#[derive(Clone, Copy, Debug)]
pub(super) struct RimRoots<T = f64> {
    pub middle: T,
    pub half: T,
    /// How far the rim swings to either side.
    pub swing: T,
}

/// A centre this near to the axis, in units of its distance, lies on it.
const CENTRAL: f64 = 4.0 * f64::EPSILON;
/// A disk this near to edge-on, in units of its distance, has an area below the rounding of everything else.
const EDGE_ON: f64 = 4.0 * f64::EPSILON;

/// What a plane leaves of a rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RimCut<T = f64> {
    Whole,
    Nothing,
    Part { from: T, to: T },
}

/// Below this the first terms of a series stand for a ratio: the next is smaller than the last bit that is asked for,
/// and slopes are not divided by zero.
const SMALL: f64 = 1.0 / (1u64 << 40) as f64;

/// atan(y)/y.
fn atan_ratio<T: Number>(y: T) -> T {
    if y.primal().abs() < SMALL { y * y * (-1.0 / 3.0) + 1.0 } else { y.atan() / y }
}

/// ln(1 + y)/y.
fn log1p_ratio<T: Number>(y: T) -> T {
    if y.primal().abs() < SMALL { y * -0.5 + 1.0 + y * y * (1.0 / 3.0) } else { y.ln_1p() / y }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn of_disk(center: DVec3, normal: DVec3, radius: f64) -> Option<Rim> {
        Rim::of_disk(Vector::constant(center), Vector::constant(normal), radius)
    }

    /// The same integral by the trapezoidal rule over a full turn, which converges geometrically.
    fn by_trapezoids(rim: &Rim, n: DVec3) -> f64 {
        let steps = 4000;
        (0..steps)
            .map(|i| {
                let t = TAU * f64::from(i) / f64::from(steps);
                let r = rim.point(t).primal();
                let (sin, cos) = t.sin_cos();
                n.dot(r.cross(((rim.v * cos - rim.u * sin) * rim.radius).primal())) / r.length_squared()
            })
            .sum::<f64>()
            * TAU
            / f64::from(steps)
    }

    #[test]
    fn the_closed_contour_is_the_integral_it_claims_to_be() {
        let n = DVec3::new(0.3, -0.4, 0.8).normalize();
        for offset in [0.0, 1e-12, 1e-6, 0.3, 2.0] {
            let rim = of_disk(DVec3::new(offset, 0.0, 1.5), DVec3::new(0.0, 0.0, -1.0), 0.75).unwrap();
            let contour = |t0: f64, t1: f64| rim.contour(Vector::constant(n), t0, t1).value;
            let sum = contour(0.3, 2.0) + contour(2.0, 0.3 + TAU);
            approx::assert_abs_diff_eq!(sum, by_trapezoids(&rim, n), epsilon = 2e-14);
            approx::assert_abs_diff_eq!(sum, contour(0.0, TAU), epsilon = 4e-15);
        }
    }

    #[test]
    fn a_direction_on_the_rim_returns_its_parameter() {
        let rim = of_disk(DVec3::new(1.0, 2.0, 1.5), DVec3::new(0.1, 0.2, 1.0).normalize(), 0.75).unwrap();
        for t in [0.1, 1.0, 3.0, 6.0] {
            approx::assert_abs_diff_eq!(rim.parameter(rim.point(t).primal() * 3.0), t, epsilon = 1e-14);
            approx::assert_abs_diff_eq!(rim.margin(rim.point(t).primal().normalize()), 0.0, epsilon = 1e-15);
            let (edge, middle) = (rim.point(t).primal().normalize(), rim.center.primal().normalize());
            let inside = (edge + (middle - edge) * 1e-3).normalize();
            let margin = rim.margin(inside);
            assert!(margin > 0.0 && margin <= edge.angle_between(inside), "{margin}");
        }
    }
}
