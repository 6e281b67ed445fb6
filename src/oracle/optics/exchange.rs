//! Two surfaces that see each other and not themselves: the radiosity equation at nodes of quadrature (Nyström's method).

use super::{Bounded, OpticsError, ROUNDINGS};
use crate::radiometry::{Albedo, Exitance};

/// How two surfaces see each other.
pub(super) trait Facing {
    /// A place on either.
    type Place: Copy + std::fmt::Debug;
    /// What a place receives per radiosity of the other surface's part that `from` stands for, over the node's weight.
    fn kernel(&self, at: Self::Place, from: Self::Place) -> f64;
}

/// Which of two surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// The one named first.
    First,
    /// The other.
    Second,
}

impl Which {
    fn index(self) -> usize {
        match self {
            Which::First => 0,
            Which::Second => 1,
        }
    }
}

/// The radiosities of both at their nodes.
#[derive(Clone, Debug)]
pub(super) struct Exchange<F: Facing> {
    facing: F,
    nodes: [Vec<(F::Place, f64)>; 2],
    albedos: [f64; 2],
    exitances: [f64; 2],
    radiosities: [Vec<f64>; 2],
}

/// Iterations, each a bounce to and fro, before the sum of bounces has to stand: with nothing absorbed and a twentieth lost
/// through the gap it takes some 700.
const MOST_ROUNDS: usize = 20_000;

/// Albedos in [0, 1], exitances ≥ 0.
pub(super) fn checked(albedos: [Albedo; 2], exitances: [Exitance; 2]) -> Result<([f64; 2], [f64; 2]), OpticsError> {
    for albedo in albedos {
        super::share("the albedo", albedo.ratio())?;
    }
    for exitance in exitances {
        let said = exitance.watts_per_square_metre();
        if !(said.is_finite() && said >= 0.0) {
            return Err(crate::radiometry::RadiometryError::Exitance { said }.into());
        }
    }
    Ok((albedos.map(Albedo::ratio), exitances.map(Exitance::watts_per_square_metre)))
}

impl<F: Facing> Exchange<F> {
    /// Solves B₁ = M₁ + ρ₁ K B₂, B₂ = M₂ + ρ₂ K B₁ at the nodes.
    ///
    /// By the bounces themselves, in turn: all terms are positive, each round loses what is absorbed and what leaves through
    /// the gap.
    pub fn new(facing: F, nodes: [Vec<(F::Place, f64)>; 2], albedos: [f64; 2], exitances: [f64; 2]) -> Exchange<F> {
        let rows = |to: usize| -> Vec<f64> {
            let (ats, froms) = (&nodes[to], &nodes[1 - to]);
            ats.iter().flat_map(|(at, _)| froms.iter().map(|(from, w)| w * facing.kernel(*at, *from))).collect()
        };
        let kernels = [rows(0), rows(1)];
        let mut radiosities = [0, 1].map(|i| vec![exitances[i]; nodes[i].len()]);
        for _ in 0..MOST_ROUNDS {
            let mut change = 0.0_f64;
            for i in [0, 1] {
                let (own, other) = (radiosities[i].clone(), &radiosities[1 - i]);
                let next: Vec<f64> = kernels[i]
                    .chunks_exact(other.len())
                    .map(|row| exitances[i] + albedos[i] * row.iter().zip(other).map(|(k, b)| k * b).sum::<f64>())
                    .collect();
                let change_of = |(new, old): (&f64, &f64)| (new - old).abs() / new.abs().max(f64::MIN_POSITIVE);
                change = next.iter().zip(&own).map(change_of).fold(change, f64::max);
                radiosities[i] = next;
            }
            if change <= 0.5 * f64::EPSILON {
                break;
            }
        }
        Exchange { facing, nodes, albedos, exitances, radiosities }
    }

    /// What a place receives, W/m².
    pub fn irradiance(&self, which: Which, at: F::Place) -> f64 {
        let i = which.index();
        self.gathered(i, at, &self.radiosities[1 - i])
    }

    fn gathered(&self, to: usize, at: F::Place, other: &[f64]) -> f64 {
        self.nodes[1 - to].iter().zip(other).map(|((from, w), b)| w * self.facing.kernel(at, *from) * b).sum()
    }

    /// Emitted and reflected together, W/m².
    pub fn radiosity(&self, which: Which, at: F::Place) -> f64 {
        let i = which.index();
        self.exitances[i] + self.albedos[i] * self.irradiance(which, at)
    }

    /// Reflected light alone, of what has been reflected at most so many times.
    pub fn reflected_after(&self, which: Which, at: F::Place, reflections: u32) -> f64 {
        let i = which.index();
        if reflections == 0 {
            return 0.0;
        }
        // Reflections in turn, ending with the one at the place itself.
        let mut on = if reflections % 2 == 1 { 1 - i } else { i };
        let mut radiosity = vec![self.exitances[on]; self.nodes[on].len()];
        for _ in 1..reflections {
            let to = 1 - on;
            let at_node = |(at, _): &(F::Place, f64)| {
                self.exitances[to] + self.albedos[to] * self.gathered(to, *at, &radiosity)
            };
            radiosity = self.nodes[to].iter().map(at_node).collect();
            on = to;
        }
        self.albedos[i] * self.gathered(i, at, &radiosity)
    }
}

/// The same layout solved twice, with fewer nodes and with more: how far they are apart is the error of the fewer.
#[derive(Clone, Debug)]
pub(super) struct Twice<F: Facing> {
    pub coarse: Exchange<F>,
    pub fine: Exchange<F>,
}

impl<F: Facing> Twice<F> {
    pub fn told(&self, question: impl Fn(&Exchange<F>) -> f64) -> Bounded {
        let (coarse, value) = (question(&self.coarse), question(&self.fine));
        Bounded { value, bound: (value - coarse).abs() + ROUNDINGS * f64::EPSILON * value.abs() }
    }
}
