//! Two equal rectangles straight opposite each other that light each other: plates that end.

use super::exchange::{Exchange, Facing, Twice, Which, checked};
use super::nodes::composite;
use super::{Bounded, OpticsError, length, place};
use crate::radiometry::{Albedo, Exitance};

/// Two parallel rectangles of the same size straight opposite each other, both diffuse.
///
/// ```text
/// B₁(x) = M₁ + ρ₁ ∫ B₂(x′) h²/(π (h² + |x − x′|²)²) dA′,   and the other way round
/// ```
///
/// Both radiosities are even in x and in y, so that a quarter of each is solved for, at Gauss's nodes (Nyström's method) on
/// panels no longer than the gap.
#[derive(Clone, Debug)]
pub struct FacingRectangles {
    half: [f64; 2],
    solved: Twice<Quarters>,
}

#[derive(Clone, Copy, Debug)]
struct Quarters {
    gap: f64,
}

impl Facing for Quarters {
    type Place = [f64; 2];
    fn kernel(&self, [x, y]: [f64; 2], [u, v]: [f64; 2]) -> f64 {
        let h = self.gap * self.gap;
        let one = |dx: f64, dy: f64| {
            let square = h + dx * dx + dy * dy;
            1.0 / (square * square)
        };
        // The node and its three mirror images.
        let sum = (one(x - u, y - v) + one(x + u, y + v)) + (one(x - u, y + v) + one(x + u, y - v));
        h / std::f64::consts::PI * sum
    }
}

impl FacingRectangles {
    /// Side over gap up to which the equation is solved.
    pub const LARGEST: f64 = 4.0;

    /// - `gap`: metres, > 0; `sides`: metres, each in (0, 4 gaps]; `albedos`: in [0, 1]; `exitances`: W/m², ≥ 0
    pub fn new(
        gap: f64,
        sides: [f64; 2],
        albedos: [Albedo; 2],
        exitances: [Exitance; 2],
    ) -> Result<FacingRectangles, OpticsError> {
        length("the gap", gap)?;
        for side in sides {
            length("the rectangle's side", side)?;
            let ratio = side / gap;
            if ratio > Self::LARGEST {
                return Err(OpticsError::TooClose { ratio, limit: Self::LARGEST });
            }
        }
        let (albedos, exitances) = checked(albedos, exitances)?;
        let half = sides.map(|side| 0.5 * side);
        let solve = |points: usize| {
            let [x, y] = half.map(|half| composite(0.0, half, (half / gap).ceil() as usize, points));
            let nodes: Vec<([f64; 2], f64)> =
                x.iter().flat_map(|(x, wx)| y.iter().map(move |(y, wy)| ([*x, *y], wx * wy))).collect();
            Exchange::new(Quarters { gap }, [nodes.clone(), nodes], albedos, exitances)
        };
        Ok(FacingRectangles { half, solved: Twice { coarse: solve(10), fine: solve(13) } })
    }

    fn on(&self, at: [f64; 2]) -> Result<[f64; 2], OpticsError> {
        for (said, half) in at.into_iter().zip(self.half) {
            place("the place", said)?;
            if said.abs() > half {
                return Err(OpticsError::Place { field: "the place", said });
            }
        }
        Ok(at)
    }

    /// Emitted and reflected together, W/m², all bounces counted.
    ///
    /// - `at`: from the middle along the sides, metres, on the rectangle
    /// - error: `bound`: rounding, and how far 10 and 13 nodes a panel are apart
    /// - source: the equations above; second witnesses: form factors for black rectangles, and the sum of bounces
    pub fn radiosity(&self, which: Which, at: [f64; 2]) -> Result<Bounded, OpticsError> {
        let at = self.on(at)?;
        Ok(self.solved.told(|solved| solved.radiosity(which, at)))
    }

    /// Reflected light alone, W/m², of what has been reflected at most so many times.
    pub fn reflected_after(&self, which: Which, at: [f64; 2], reflections: u32) -> Result<Bounded, OpticsError> {
        let at = self.on(at)?;
        Ok(self.solved.told(|solved| solved.reflected_after(which, at, reflections)))
    }

    /// What arrives, W/m², all bounces counted.
    pub fn irradiance(&self, which: Which, at: [f64; 2]) -> Result<Bounded, OpticsError> {
        let at = self.on(at)?;
        Ok(self.solved.told(|solved| solved.irradiance(which, at)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::patch;
    use approx::assert_relative_eq;

    fn pair(gap: f64, sides: [f64; 2], albedos: [f64; 2], exitances: [f64; 2]) -> FacingRectangles {
        FacingRectangles::new(gap, sides, albedos.map(Albedo::new), exitances.map(Exitance::new)).unwrap()
    }

    /// Power on one rectangle of what the other's light makes of it.
    fn power(pair: &FacingRectangles, which: Which) -> f64 {
        let [x, y] = pair.half.map(|half| composite(-half, half, 6, 12));
        let row = |x: f64| -> f64 { y.iter().map(|(y, w)| w * pair.irradiance(which, [x, *y]).unwrap().value).sum() };
        x.iter().map(|(x, w)| w * row(*x)).sum()
    }

    #[test]
    fn without_reflection_it_is_a_form_factor() {
        for (gap, sides) in [(1.0, [1.0, 1.0]), (0.5, [1.0, 0.3]), (0.5, [2.0, 1.0])] {
            let black = pair(gap, sides, [0.0, 0.0], [0.0, 1.0]);
            let factor = patch::rectangle_to_opposite_rectangle(sides[0], sides[1], gap).unwrap().ratio();
            assert_relative_eq!(power(&black, Which::First), sides[0] * sides[1] * factor, max_relative = 1e-12);
        }
    }

    /// Nothing is lost: emitted = absorbed + what leaves through the gap, told by the form factors of the radiosity.
    #[test]
    fn bounces_add_up_to_all() {
        let both = pair(0.5, [1.0, 0.8], [0.7, 0.9], [1.0, 0.25]);
        for which in [Which::First, Which::Second] {
            let all = both.radiosity(which, [0.3, -0.2]).unwrap();
            let many = both.reflected_after(which, [0.3, -0.2], 60).unwrap();
            let emitted = if which == Which::First { 1.0 } else { 0.25 };
            assert_relative_eq!(emitted + many.value, all.value, max_relative = 1e-10);
            assert!(all.bound < 1e-12 * all.value, "{all:?}");
            let mirrored = both.radiosity(which, [-0.3, 0.2]).unwrap();
            assert_relative_eq!(mirrored.value, all.value, max_relative = 1e-14);
        }
    }

    /// Reciprocity: with equal albedos, what a lamp on one does to the other it does the other way round.
    #[test]
    fn it_does_not_matter_which_is_the_lamp() {
        let there = pair(0.5, [1.0, 1.0], [0.5, 0.8], [1.0, 0.0]);
        let back = pair(0.5, [1.0, 1.0], [0.8, 0.5], [0.0, 1.0]);
        let place = [0.1, 0.4];
        let (a, b) = (there.irradiance(Which::Second, place).unwrap(), back.irradiance(Which::First, place).unwrap());
        assert_relative_eq!(a.value, b.value, max_relative = 1e-14);
    }

    #[test]
    fn what_is_no_pair_is_refused() {
        let (half, one) = ([0.5, 0.5].map(Albedo::new), [1.0, 0.0].map(Exitance::new));
        assert!(matches!(FacingRectangles::new(0.2, [1.0, 1.0], half, one), Err(OpticsError::TooClose { .. })));
        assert!(FacingRectangles::new(1.0, [1.0, -1.0], half, one).is_err());
        let both = FacingRectangles::new(1.0, [1.0, 2.0], half, one).unwrap();
        assert!(
            both.radiosity(Which::First, [0.6, 0.0]).is_err() && both.radiosity(Which::First, [0.4, 0.9]).is_ok()
        );
    }
}
