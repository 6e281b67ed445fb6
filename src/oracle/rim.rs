//! The rim of a disk (or the silhouette of a ball) as a curve of directions, and its contour integral.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::Frame;

/// A circle around `center`, seen from the origin: `r(t) = center + radius (u cos t + v sin t)`.
///
/// `axis` points away from the origin (`height > 0`), so that growing `t` runs counter-clockwise as seen from it and
/// the disk lies on the side `r × dr`. Along the rim `|r|² = P + Q cos t`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rim {
    pub center: DVec3,
    /// Along the centre's offset from the axis foot.
    pub u: DVec3,
    pub v: DVec3,
    pub axis: DVec3,
    pub radius: f64,
    /// Of the plane: `center · axis`, > 0.
    pub height: f64,
    /// Of the centre from the plane's foot point: `center · u`, ≥ 0.
    pub offset: f64,
}

/// A contour term, and the sum of the sizes of what it was added from, weighed by their conditioning: the error of
/// `value` is a few `f64::EPSILON · weight`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Term {
    pub value: f64,
    pub weight: f64,
}

impl std::ops::AddAssign for Term {
    fn add_assign(&mut self, other: Term) {
        self.value += other.value;
        self.weight += other.weight;
    }
}

impl Rim {
    /// The rim of a disk with unit normal `normal` (either side). `None` for a disk seen edge-on: it has no area.
    pub fn of_disk(center: DVec3, normal: DVec3, radius: f64) -> Option<Rim> {
        let along = center.dot(normal);
        if along.abs() <= EDGE_ON * (center.length() + radius) {
            return None;
        }
        let axis = if along < 0.0 { -normal } else { normal };
        let height = along.abs();
        let sideways = center - axis * height;
        let (u, offset) = if sideways.length() <= 4.0 * f64::EPSILON * center.length() {
            (Frame::around(axis).tangent, 0.0)
        } else {
            // Once more: what is left of the axis after one subtraction is large beside a small offset.
            let u = sideways.normalize();
            let u = (u - axis * u.dot(axis)).normalize();
            (u, center.dot(u))
        };
        Some(Rim { center, u, v: axis.cross(u), axis, radius, height, offset })
    }

    /// The circle in which the ball's tangent cone touches it. `None` if the origin is inside or on the ball.
    ///
    /// The circle's centre lies on its axis by construction: measuring that offset would return rounding noise.
    pub fn of_silhouette(center: DVec3, radius: f64) -> Option<Rim> {
        let distance = center.length();
        let sine = radius / distance;
        if sine >= 1.0 {
            return None;
        }
        let axis = center / distance;
        let cosine_squared = (distance - radius) * (distance + radius) / (distance * distance);
        let height = distance * cosine_squared;
        let frame = Frame::around(axis);
        Some(Rim {
            center: axis * height,
            u: frame.tangent,
            v: frame.bitangent,
            axis,
            radius: radius * cosine_squared.sqrt(),
            height,
            offset: 0.0,
        })
    }

    pub fn point(&self, t: f64) -> DVec3 {
        let (sin, cos) = t.sin_cos();
        self.center + (self.u * cos + self.v * sin) * self.radius
    }

    /// The parameter, in [0, 2π), of the rim's point in a direction that meets it.
    pub fn parameter(&self, direction: DVec3) -> f64 {
        let hit = direction * (self.height / direction.dot(self.axis));
        let t = hit.dot(self.v).atan2(hit.dot(self.u) - self.offset);
        if t < 0.0 { t + TAU } else { t }
    }

    /// Signed angle (a sine; lower bound of its size up to the foreshortening at the far side) from the cone's mantle to
    /// a unit direction: positive inside the cone.
    pub fn margin(&self, d: DVec3) -> f64 {
        let (du, dv, dw) = (d.dot(self.u), d.dot(self.v), d.dot(self.axis));
        let out = (self.height * du - self.offset * dw).hypot(self.height * dv);
        (self.radius * dw - out) / self.height.hypot(self.offset + self.radius)
    }

    /// Two ends of the part where `plane · r(t) + k ≥ 0`; `Whole` and `Nothing` where the rim does not cross.
    pub fn cut(&self, plane: DVec3, k: f64) -> RimCut {
        let level = plane.dot(self.center) + k;
        let (pu, pv) = (plane.dot(self.u), plane.dot(self.v));
        let swing = self.radius * pu.hypot(pv);
        let noise = 4.0 * f64::EPSILON * (self.center.length() + self.radius + k.abs());
        // A rim that lies in the plane has nothing before it: this question comes first.
        if level <= noise - swing {
            RimCut::Nothing
        } else if level >= swing - noise {
            RimCut::Whole
        } else {
            let half = ((swing - level) * (swing + level)).sqrt().atan2(-level);
            let middle = pv.atan2(pu);
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
    pub fn contour(&self, n: DVec3, t0: f64, t1: f64) -> Term {
        let (a, cw, cu) = (self.radius, self.height, self.offset);
        let (nu, nv, nw) = (n.dot(self.u), n.dot(self.v), n.dot(self.axis));
        let near = cw.hypot(cu - a);
        let far = cw.hypot(cu + a);
        let p = cw * cw + cu * cu + a * a;
        let q = 2.0 * a * cu;
        let d = near * far;
        let b = q / (p + d);
        let turn = t1 - t0;
        let (sin0, cos0) = t0.sin_cos();
        let (sin1, cos1) = t1.sin_cos();
        let psi_over_b = |sin: f64, cos: f64| {
            let x = sin / (1.0 + b * cos);
            x * atan_ratio(b * x)
        };
        let delta = psi_over_b(sin1, cos1) - psi_over_b(sin0, cos0);
        let i0 = (turn - 2.0 * b * delta) / d;
        let i1 = (-b * turn + 2.0 * p / (p + d) * delta) / d;
        let delta_cos = -2.0 * (0.5 * (t0 + t1)).sin() * (0.5 * turn).sin();
        let start = cw * cw + (cu + a * cos0) * (cu + a * cos0) + (a * sin0) * (a * sin0);
        let i2 = -delta_cos / start * log1p_ratio(q * delta_cos / start);
        let (f0, f1, f2) = (a * a * nw, a * (cu * nw - cw * nu), -a * cw * nv);
        let sizes = f0.abs() * (turn + 2.0 * (b * delta).abs()) / d
            + f1.abs() * (b * turn + 2.0 * delta.abs()) / d
            + (f2 * i2).abs();
        // The ends are known to the rounding of an angle, whatever the length between them.
        let stop = cw * cw + (cu + a * cos1) * (cu + a * cos1) + (a * sin1) * (a * sin1);
        let ends = (f0.abs() + f1.abs() + f2.abs()) * (t0.abs() / start + t1.abs() / stop);
        Term { value: f0 * i0 + f1 * i1 + f2 * i2, weight: sizes * (far / near) + 0.25 * ends }
    }
}

/// A disk this near to edge-on, in units of its distance, has an area below the rounding of everything else.
const EDGE_ON: f64 = 4.0 * f64::EPSILON;

/// What a plane leaves of a rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum RimCut {
    Whole,
    Nothing,
    Part { from: f64, to: f64 },
}

/// atan(y)/y.
fn atan_ratio(y: f64) -> f64 {
    if y == 0.0 { 1.0 } else { y.atan() / y }
}

/// ln(1 + y)/y.
fn log1p_ratio(y: f64) -> f64 {
    if y == 0.0 { 1.0 } else { y.ln_1p() / y }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same integral by the trapezoidal rule over a full turn, which converges geometrically.
    fn by_trapezoids(rim: &Rim, n: DVec3) -> f64 {
        let steps = 4000;
        (0..steps)
            .map(|i| {
                let t = TAU * f64::from(i) / f64::from(steps);
                let r = rim.point(t);
                let (sin, cos) = t.sin_cos();
                n.dot(r.cross((rim.v * cos - rim.u * sin) * rim.radius)) / r.length_squared()
            })
            .sum::<f64>()
            * TAU
            / f64::from(steps)
    }

    #[test]
    fn the_closed_contour_is_the_integral_it_claims_to_be() {
        let n = DVec3::new(0.3, -0.4, 0.8).normalize();
        for offset in [0.0, 1e-12, 1e-6, 0.3, 2.0] {
            let rim = Rim::of_disk(DVec3::new(offset, 0.0, 1.5), DVec3::new(0.0, 0.0, -1.0), 0.75).unwrap();
            let sum = rim.contour(n, 0.3, 2.0).value + rim.contour(n, 2.0, 0.3 + TAU).value;
            approx::assert_abs_diff_eq!(sum, by_trapezoids(&rim, n), epsilon = 2e-14);
            approx::assert_abs_diff_eq!(sum, rim.contour(n, 0.0, TAU).value, epsilon = 4e-15);
        }
    }

    #[test]
    fn a_direction_on_the_rim_returns_its_parameter() {
        let rim = Rim::of_disk(DVec3::new(1.0, 2.0, 1.5), DVec3::new(0.1, 0.2, 1.0).normalize(), 0.75).unwrap();
        for t in [0.1, 1.0, 3.0, 6.0] {
            approx::assert_abs_diff_eq!(rim.parameter(rim.point(t) * 3.0), t, epsilon = 1e-14);
            approx::assert_abs_diff_eq!(rim.margin(rim.point(t).normalize()), 0.0, epsilon = 1e-15);
            let (edge, middle) = (rim.point(t).normalize(), rim.center.normalize());
            let inside = (edge + (middle - edge) * 1e-3).normalize();
            let margin = rim.margin(inside);
            assert!(margin > 0.0 && margin <= edge.angle_between(inside), "{margin}");
        }
    }
}
