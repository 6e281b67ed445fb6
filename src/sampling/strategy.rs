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
}

impl Strategy {
    /// All of them, in the order of reports.
    pub const ALL: [Strategy; 3] = [Strategy::Random, Strategy::Correlated, Strategy::Stratified];
    /// The three at the heart of the study: what a case measures that names none.
    pub const LECTURE: [Strategy; 3] = [Strategy::Random, Strategy::Correlated, Strategy::Stratified];

    /// The name that case files and reports use.
    pub fn name(self) -> &'static str {
        match self {
            Strategy::Random => "random",
            Strategy::Correlated => "correlated",
            Strategy::Stratified => "stratified",
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
        }
    }

    /// What the points are points of: where directions or places are drawn from, and with which density.
    pub fn technique(self) -> Technique {
        match self {
            Strategy::Random | Strategy::Correlated | Strategy::Stratified => Technique::Area,
        }
    }

    /// How the points of one estimate lie to one another.
    pub fn point_set(self) -> PointSet {
        match self {
            Strategy::Random | Strategy::Correlated => PointSet::Independent,
            Strategy::Stratified => PointSet::Stratified,
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
