//! The ways of choosing points on a source.

use std::fmt;

/// What a strategy draws, and with which density.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Technique {
    /// Places on the source, uniform by area.
    Area,
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

/// A point pattern, and whether its points are fresh for each shading point or shared by all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
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
}

impl Strategy {
    /// All of them, in the order of reports.
    pub const ALL: [Strategy; 7] = [
        Strategy::Random,
        Strategy::Correlated,
        Strategy::Stratified,
        Strategy::UniformJitter,
        Strategy::LatinHypercube,
        Strategy::MultiJittered,
        Strategy::Sobol,
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
        }
    }

    /// How the points of one estimate lie to one another.
    pub fn point_set(self) -> PointSet {
        match self {
            Strategy::Random | Strategy::Correlated => PointSet::Independent,
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
