//! All light of a beam that falls on a convex body of glass along its axis, whatever its number of interactions.
//!
//! A ray stays in its meridian plane, where it is a chain: at each face one part leaves, the other stays. So the flux that one
//! order brings to a receiver is an integral over the beam's radius of what that chain's part carries, times the share of the
//! landing circle that lies on the receiver.

use std::f64::consts::TAU;

use super::Bounded;
use super::ball::glass_face;
use super::faces::Polarised;
use crate::oracle::quadrature::rule::{self, Demand, Ends};

/// A body of revolution around the z axis, seen in a meridian plane.
#[derive(Clone, Copy, Debug)]
pub(super) enum Body {
    /// Around the origin, metres.
    Ball { radius: f64 },
    /// Flat face up, at z = `thickness`; vertex of the other at z = 0, metres.
    Lens { radius: f64, thickness: f64 },
}

/// A level receiver around the axis, by its half extents, or its radius, metres.
#[derive(Clone, Copy, Debug)]
pub(super) enum Field {
    Rectangle([f64; 2]),
    Disk(f64),
}

impl Field {
    /// The angle under which a circle around the axis lies on it.
    fn angle(self, radius: f64) -> f64 {
        match self {
            Field::Disk(limit) => {
                if radius <= limit {
                    TAU
                } else {
                    0.0
                }
            }
            Field::Rectangle(half) => {
                let cut = |half: f64| if radius > half { 4.0 * (half / radius).acos() } else { 0.0 };
                (TAU - cut(half[0]) - cut(half[1])).max(0.0)
            }
        }
    }
    /// Between which of the radii where that angle has a corner a circle lies.
    fn class(self, radius: f64) -> u8 {
        let corners = match self {
            Field::Disk(limit) => [limit; 3],
            Field::Rectangle([a, b]) => [a.min(b), a.max(b), a.hypot(b)],
        };
        corners.iter().filter(|corner| radius > **corner).count() as u8
    }
}

/// A beam along −z around the axis, and where it is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    pub body: Body,
    pub index: f64,
    pub beam_radius: f64,
    /// Of the receiver's plane, which faces up.
    pub height: f64,
    pub field: Field,
}

/// What leaves a body at one interaction.
#[derive(Clone, Copy)]
struct Left {
    /// Distance from the axis where it lands; `None`: it goes up, or nothing leaves.
    landing: Option<f64>,
    share: f64,
    /// Nothing may leave: total reflection.
    is_total: bool,
}

/// A place or a direction in the plane: (x, z).
type Flat = [f64; 2];

fn dot(a: Flat, b: Flat) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn along(from: Flat, by: f64, direction: Flat) -> Flat {
    [from[0] + by * direction[0], from[1] + by * direction[1]]
}

fn unit(direction: Flat) -> Flat {
    let length = direction[0].hypot(direction[1]);
    direction.map(|x| x / length)
}

impl Passage {
    /// Power on the receiver by light of up to `depth` interactions, over the beam's irradiance: m².
    ///
    /// - error: `bound`, an estimate: of quadrature between corners that are searched for in [`LOOKS`] places
    pub fn power(&self, depth: usize) -> Bounded {
        (1..=depth).map(|order| self.power_of(order)).fold(Bounded::default(), |sum, part| Bounded {
            value: sum.value + part.value,
            bound: sum.bound + part.bound,
        })
    }

    /// The same of one order.
    pub fn power_of(&self, order: usize) -> Bounded {
        let class = |h: f64| {
            let left = self.leaves(h, order);
            (left.landing.map(|radius| self.field.class(radius)), left.is_total)
        };
        let at = |k: usize| self.beam_radius * k as f64 / LOOKS as f64;
        let mut breaks = vec![0.0];
        let mut before = class(at(0));
        for k in 1..=LOOKS {
            let here = class(at(k));
            if here != before {
                let (mut low, mut high) = (at(k - 1), at(k));
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if class(middle) == before { low = middle } else { high = middle }
                }
                breaks.push(0.5 * (low + high));
            }
            before = here;
        }
        breaks.push(self.beam_radius);
        let integrand = |h: f64| {
            let left = self.leaves(h, order);
            [left.landing.map_or(0.0, |radius| h * left.share * self.field.angle(radius))]
        };
        let demand = |sum: &[f64; 1]| Demand { goal: [1e-15 + 1e-13 * sum[0]], floor: |value| [1e-16 * value[0]] };
        let found = rule::integrate(&breaks, Ends::Roots, 1e-9 * self.beam_radius, MOST_PANELS, integrand, demand);
        Bounded { value: found.value[0], bound: found.error[0] + Bounded::rounded(found.value[0]).bound }
    }

    /// What leaves at an order, of a ray at the distance h from the axis.
    fn leaves(&self, h: f64, order: usize) -> Left {
        let (mut place, normal) = self.top(h);
        let [through, back] = glass_face(self.index, normal[1]);
        let down = [0.0, -1.0];
        if order == 1 {
            return self.landed(place, along(down, 2.0 * normal[1], normal), back);
        }
        let (mut direction, _) = refracted(down, [-normal[0], -normal[1]], 1.0 / self.index);
        let mut carried = through;
        for step in 2.. {
            let (exit, normal) = self.exit(place, direction);
            let (outside, cosine) = refracted(direction, normal, self.index);
            let [through, back] = glass_face(self.index, cosine);
            let is_total = cosine <= 0.0;
            if step == order {
                let left = self.landed(exit, outside, carried.then(through));
                return if is_total { Left { landing: None, share: 0.0, is_total } } else { left };
            }
            if !is_total {
                carried = carried.then(back);
            }
            place = exit;
            direction = unit(along(direction, -2.0 * dot(direction, normal), normal));
        }
        unreachable!("the loop ends at the order, which is 2 or more")
    }

    fn landed(&self, from: Flat, direction: Flat, share: Polarised) -> Left {
        let falls = direction[1] < 0.0;
        let landing = falls.then(|| (from[0] + direction[0] * (self.height - from[1]) / direction[1]).abs());
        Left { landing, share: share.mean(), is_total: false }
    }

    /// Where a ray of the beam meets the body, and the outward normal.
    fn top(&self, h: f64) -> (Flat, Flat) {
        match self.body {
            Body::Ball { radius } => {
                let z = ((radius - h) * (radius + h)).max(0.0).sqrt();
                ([h, z], [h / radius, z / radius])
            }
            Body::Lens { thickness, .. } => ([h, thickness], [0.0, 1.0]),
        }
    }

    /// Where a ray inside comes to the next face, and the outward normal there.
    fn exit(&self, from: Flat, direction: Flat) -> (Flat, Flat) {
        let (radius, center, flat) = match self.body {
            Body::Ball { radius } => (radius, 0.0, None),
            Body::Lens { radius, thickness } => (radius, radius, Some(thickness)),
        };
        let out = [from[0], from[1] - center];
        // The far root, from a place on the sphere or within.
        let middle = -dot(out, direction);
        let to_sphere = middle + (middle * middle + (radius * radius - dot(out, out)).max(0.0)).sqrt();
        if let Some(top) = flat {
            let to_top = (top - from[1]) / direction[1];
            if direction[1] > 0.0 && to_top <= to_sphere {
                return (along(from, to_top, direction), [0.0, 1.0]);
            }
        }
        // Back onto the sphere: what a hop is off by would grow with every further one.
        let normal = unit(along(out, to_sphere, direction));
        (along([0.0, center], radius, normal), normal)
    }
}

/// The refracted direction, and the cosine on the far side (0: total reflection).
///
/// - `normal`: towards the far side; `ratio`: index of the near side over the far side's
fn refracted(direction: Flat, normal: Flat, ratio: f64) -> (Flat, f64) {
    let cosine = dot(direction, normal);
    let sine = direction[0] * normal[1] - direction[1] * normal[0];
    let far = 1.0 - (ratio * sine).powi(2);
    if far <= 0.0 {
        return (direction, 0.0);
    }
    let far = far.sqrt();
    let bent = [0, 1].map(|k| ratio * direction[k] + (far - ratio * cosine) * normal[k]);
    (bent, far)
}

/// Places along the beam's radius at which corners are looked for.
const LOOKS: usize = 4096;
const MOST_PANELS: usize = 2000;

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::super::{Caustic, Loss};
    use super::*;

    const BALL: Passage = Passage {
        body: Body::Ball { radius: 1.0 },
        index: 1.5,
        beam_radius: 0.875,
        height: -1.25,
        field: Field::Rectangle([2.0, 1.5]),
    };
    const LENS: Passage = Passage {
        body: Body::Lens { radius: 2.0, thickness: 0.267_949_192_431_122_7 },
        index: 1.5,
        beam_radius: 0.75,
        height: -2.0,
        field: Field::Rectangle([0.3, 0.2]),
    };

    #[test]
    fn the_first_passage_is_the_caustic() {
        let ball = Caustic::glass_ball(1.0, 1.5, 1.25, 0.875, Loss::PerPolarisation).unwrap();
        let lens = Caustic::plano_convex(2.0, 1.5, 2.0, 0.75, Loss::PerPolarisation).unwrap();
        let narrow = Passage { field: Field::Rectangle([0.1, 0.4]), ..BALL };
        for (passage, caustic, [a, b]) in
            [(BALL, &ball, [2.0, 1.5]), (narrow, &ball, [0.1, 0.4]), (LENS, &lens, [0.3, 0.2])]
        {
            let known = caustic.power_in_rectangle([-a, a], [-b, b]).unwrap();
            let found = passage.power_of(2);
            assert!((found.value / known.value - 1.0).abs() < 1e-12, "{found:?}, not {known:?}");
        }
    }

    #[test]
    fn all_orders_together_are_the_beam() {
        // Shares of what leaves a ball: (1 − R)² Σ Rᵏ + R = 1, each polarisation by itself.
        for passage in [BALL, LENS] {
            for h in [0.0, 0.2, 0.51, 0.7] {
                let sum: f64 = (1..60).map(|order| passage.leaves(h, order).share).sum();
                assert!((sum - 1.0).abs() < 1e-14, "{h}: {sum}");
            }
        }
    }

    #[test]
    fn a_reflection_is_the_mirror_ball() {
        // Off its outside, by 2i: on a wide receiver lands what i > 45° sends below the horizon, times its reflectance.
        let wide = Passage { field: Field::Disk(1e9), ..BALL };
        let found = wide.power_of(1).value;
        let n = 100_000;
        let (low, high) = (0.5f64.sqrt(), 0.875);
        let sum: f64 = (0..n)
            .map(|k| {
                let h = low + (high - low) * (k as f64 + 0.5) / n as f64;
                let [_, back] = glass_face(1.5, (1.0 - h * h).sqrt());
                TAU * h * back.mean() * (high - low) / n as f64
            })
            .sum();
        assert!((found / sum - 1.0).abs() < 1e-8, "{found} {sum}");
        assert!(found < 0.1 * PI * high * high);
    }
}
