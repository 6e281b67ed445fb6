//! The ways of choosing points on a source, or directions that may meet it.

use std::fmt;

/// What a strategy draws, and with which density.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Technique {
    /// Places on the source, uniform by area.
    Area,
    /// Directions in which each source is seen, uniform by solid angle.
    SolidAngle,
    /// Directions of the hemisphere, with density cosθᵢ/π, that must find the sources by themselves.
    Cosine,
    /// Places by area and directions by cosine together, each weighed against the other (multiple importance sampling).
    Mis(Heuristic),
}

/// How much a sample counts where two techniques could have drawn it (Veach, *Robust Monte Carlo Methods for Light
/// Transport Simulation*, PhD thesis, Stanford 1997, section 9.2): the technique of density p, beside one of density q with as
/// many samples, gets the weight pᵝ/(pᵝ + qᵝ).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Heuristic {
    /// β = 1.
    Balance,
    /// β = 2.
    Power,
}

impl Heuristic {
    /// β.
    pub fn exponent(self) -> i32 {
        match self {
            Heuristic::Balance => 1,
            Heuristic::Power => 2,
        }
    }

    /// The weight of a technique whose density is `ratio` times the other's.
    ///
    /// - `ratio`: in [0, ∞]
    /// - returns a number in [0, 1]; for `ratio` and 1/`ratio` together one, to 2⁻⁵²
    #[inline(always)]
    pub fn weight(self, ratio: f64) -> f64 {
        let inverse = 1.0 / ratio;
        match self {
            Heuristic::Balance => 1.0 / (1.0 + inverse),
            Heuristic::Power => 1.0 / (1.0 + inverse * inverse),
        }
    }
}

/// How the points of one estimate lie to one another in the unit square. Each by itself is uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PointSet {
    /// N independent points.
    Independent,
    /// One in each of N strata of equal area.
    Stratified,
    /// One in each of N strata of equal area, at the same place in all of them.
    UniformJitter,
    /// N rooks: one in each of N columns, one in each of N rows.
    LatinHypercube,
    /// One in each of N strata that are also N rooks.
    MultiJittered,
    /// The first N points of Sobol's (0,2)-sequence, scrambled after Owen.
    Sobol,
}

impl PointSet {
    /// Whether the order of the points is drawn too, so that point k of one source falls into each stratum of that source
    /// equally often, and pairs with point k of another source are pairs of anything with anything. Where it is not, point
    /// k lies in stratum k of every source: of no consequence to a sum over sources, whose points are never paired, but
    /// not to be used for the dimensions of a path.
    pub fn draws_its_order(self) -> bool {
        match self {
            PointSet::Independent | PointSet::LatinHypercube | PointSet::MultiJittered | PointSet::Sobol => true,
            PointSet::Stratified | PointSet::UniformJitter => false,
        }
    }
}

/// What is drawn (points on the sources, directions), how the draws of one estimate lie to one another, and whether they
/// are fresh for each shading point or shared by all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Strategy {
    /// N independent uniform points, fresh for each shading point.
    Random,
    /// One set of N independent uniform points, shared by all shading points of a replicate.
    Correlated,
    /// One uniform point in each of N strata of equal area, fresh for each shading point.
    Stratified,
    /// One point in each of N strata of equal area, at one random place that is the same in all of them; fresh for each
    /// shading point.
    UniformJitter,
    /// N rooks, in random order, fresh for each shading point (McKay, Beckman & Conover 1979).
    LatinHypercube,
    /// N strata that are N rooks too, fresh for each shading point (Chiu, Shirley & Wang 1994).
    MultiJittered,
    /// Sobol's (0,2)-sequence with nested uniform scrambling, fresh for each shading point (Owen 1995).
    Sobol,
    /// N independent directions, uniform in the solid angle of each source, fresh for each shading point.
    SolidAngle,
    /// N independent cosine-weighted directions of the hemisphere, fresh for each shading point.
    Cosine,
    /// N independent points on each source and N cosine-weighted directions, weighed by the balance heuristic.
    MisBalance,
    /// The same, weighed by the power heuristic with exponent 2.
    MisPower,
}

impl Strategy {
    /// All of them, in the order of reports.
    pub const ALL: [Strategy; 11] = [
        Strategy::Random,
        Strategy::Correlated,
        Strategy::Stratified,
        Strategy::UniformJitter,
        Strategy::LatinHypercube,
        Strategy::MultiJittered,
        Strategy::Sobol,
        Strategy::SolidAngle,
        Strategy::Cosine,
        Strategy::MisBalance,
        Strategy::MisPower,
    ];
    /// The three at the heart of the study: what a case measures that names none.
    pub const LECTURE: [Strategy; 3] = [Strategy::Random, Strategy::Correlated, Strategy::Stratified];

    /// The name that case files and reports use.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::Random => "random",
            Strategy::Correlated => "correlated",
            Strategy::Stratified => "stratified",
            Strategy::UniformJitter => "uniform-jitter",
            Strategy::LatinHypercube => "latin-hypercube",
            Strategy::MultiJittered => "multi-jittered",
            Strategy::Sobol => "sobol",
            Strategy::SolidAngle => "solid-angle",
            Strategy::Cosine => "cosine",
            Strategy::MisBalance => "mis-balance",
            Strategy::MisPower => "mis-power",
        }
    }

    /// In a few words, for people.
    pub fn meaning(self) -> &'static str {
        match self {
            Strategy::Random => "N independent uniform points, fresh for each shading point",
            Strategy::Correlated => "shared points: one random set of N for all shading points of a replicate",
            Strategy::Stratified => {
                "one jittered point in each of N strata of equal area, fresh for each shading point"
            }
            Strategy::UniformJitter => "a point in each of N strata, all jittered alike: the grid shifted as a whole",
            Strategy::LatinHypercube => {
                "N rooks: one jittered point in each of N columns and N rows, in random order"
            }
            Strategy::MultiJittered => "one point in each of N strata, and in each of N columns and N rows",
            Strategy::Sobol => "Sobol's (0,2)-sequence, scrambled after Owen for each shading point",
            Strategy::SolidAngle => "N independent directions, uniform in the solid angle of each source",
            Strategy::Cosine => "N independent cosine-weighted directions, which must find the sources by themselves",
            Strategy::MisBalance => {
                "N points by area and N cosine-weighted directions together, weighed by the balance heuristic"
            }
            Strategy::MisPower => {
                "N points by area and N cosine-weighted directions together, weighed by the power heuristic"
            }
        }
    }

    /// What the points are points of: where directions or places are drawn from, and with which density.
    pub fn technique(self) -> Technique {
        match self {
            Strategy::Random
            | Strategy::Correlated
            | Strategy::Stratified
            | Strategy::UniformJitter
            | Strategy::LatinHypercube
            | Strategy::MultiJittered
            | Strategy::Sobol => Technique::Area,
            Strategy::SolidAngle => Technique::SolidAngle,
            Strategy::Cosine => Technique::Cosine,
            Strategy::MisBalance => Technique::Mis(Heuristic::Balance),
            Strategy::MisPower => Technique::Mis(Heuristic::Power),
        }
    }

    /// How the points of one estimate lie to one another.
    pub fn point_set(self) -> PointSet {
        match self {
            Strategy::Random
            | Strategy::Correlated
            | Strategy::SolidAngle
            | Strategy::Cosine
            | Strategy::MisBalance
            | Strategy::MisPower => PointSet::Independent,
            Strategy::Stratified => PointSet::Stratified,
            Strategy::UniformJitter => PointSet::UniformJitter,
            Strategy::LatinHypercube => PointSet::LatinHypercube,
            Strategy::MultiJittered => PointSet::MultiJittered,
            Strategy::Sobol => PointSet::Sobol,
        }
    }

    /// Whether one set of points serves all shading points of a replicate.
    pub fn shares_points(self) -> bool {
        self == Strategy::Correlated
    }

    /// Keys the strategy's streams. Fixed for ever: a new strategy takes a new number.
    pub(super) fn stream_id(self) -> u64 {
        match self {
            Strategy::Random => 1,
            Strategy::Correlated => 2,
            Strategy::Stratified => 3,
            Strategy::Sobol => 4,
            Strategy::UniformJitter => 5,
            Strategy::LatinHypercube => 6,
            Strategy::MultiJittered => 7,
            Strategy::SolidAngle => 8,
            Strategy::Cosine => 9,
            Strategy::MisBalance => 10,
            Strategy::MisPower => 11,
        }
    }

    /// The strategy of that name.
    pub fn from_name(name: &str) -> Option<Strategy> {
        Strategy::ALL.into_iter().find(|s| s.name() == name)
    }
}

impl fmt::Display for Strategy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{prop_assert, proptest};
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn the_weights_of_two_techniques_sum_to_one(exponent in -320.0..308.0) {
            let ratio = 10_f64.powf(exponent);
            for heuristic in [Heuristic::Balance, Heuristic::Power] {
                let (one, other) = (heuristic.weight(ratio), heuristic.weight(1.0 / ratio));
                prop_assert!((one + other - 1.0).abs() <= 2.0 * f64::EPSILON, "{} {}", one, other);
                // By Veach's own words, where nothing overflows.
                let powers = (ratio.powi(heuristic.exponent()), 1.0);
                if powers.0.is_normal() {
                    prop_assert!((one - powers.0 / (powers.0 + powers.1)).abs() <= 4.0 * f64::EPSILON);
                }
            }
        }
    }

    #[test]
    fn a_technique_that_cannot_draw_a_sample_has_no_say() {
        for heuristic in [Heuristic::Balance, Heuristic::Power] {
            assert_eq!((heuristic.weight(0.0), heuristic.weight(f64::INFINITY)), (0.0, 1.0));
        }
    }

    #[test]
    fn names_and_streams_are_its_own() {
        let names: BTreeSet<_> = Strategy::ALL.map(Strategy::name).into();
        let streams: BTreeSet<_> = Strategy::ALL.map(Strategy::stream_id).into();
        assert_eq!((names.len(), streams.len()), (Strategy::ALL.len(), Strategy::ALL.len()));
        for strategy in Strategy::ALL {
            assert_eq!(Strategy::from_name(strategy.name()), Some(strategy));
        }
    }
}
