//! Where shadows begin and end along a measured line.
//!
//! In closed form for one source and one occluder in one of three poses (see [`LimitMethod::ClosedForm`]); by search
//! everywhere else.
//!
//! Limits of the search: a stretch shorter than 1/1024 of the line that begins and ends between two scanned places may be
//! missed. Where an occluder may reach into a sphere source an antumbra counts as the penumbra that it is a part of.

mod closed;
mod path;
mod search;

use std::fmt;

use glam::DVec3;

use super::truth::Region;
use crate::configuration::Configuration;

pub use path::{NoPath, Path};

/// What a point sees of the sources: a [`Region`], with the core of an annular eclipse told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// As [`Region::BelowHorizon`].
    BelowHorizon,
    /// As [`Region::Umbra`].
    Umbra,
    /// Sees the whole outline of every source, and an occluder before one: a closed ring of it is left. A part of the penumbra.
    Antumbra,
    /// As [`Region::Penumbra`], but for the antumbra.
    Penumbra,
    /// As [`Region::Lit`].
    Lit,
}

impl Phase {
    /// The region that it is a part of.
    pub fn region(self) -> Region {
        match self {
            Phase::BelowHorizon => Region::BelowHorizon,
            Phase::Umbra => Region::Umbra,
            Phase::Antumbra | Phase::Penumbra => Region::Penumbra,
            Phase::Lit => Region::Lit,
        }
    }
}

/// How a limit was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitMethod {
    /// From one source and one occluder, wholly before each other and above the horizon all along a straight line:
    /// parallel disks and a line parallel to them; parallel rectangles with parallel edges and a line parallel to both;
    /// two spheres and any line past them.
    ClosedForm,
    /// A scan of the line, then bisection on the exact side's own classification until no number lies between, or until
    /// it cannot tell ([`Region::Edge`]). Its bounds are measured, not proved: eight times the largest misplacement in 9,000
    /// random rooms that have a closed form, for the shadow's lever and its slant; shapes nearer to one another than a
    /// hundredth of the room's size are taken to be that far apart.
    Bisection,
}

impl LimitMethod {
    /// The name that reports use.
    pub fn name(self) -> &'static str {
        match self {
            LimitMethod::ClosedForm => "closed-form",
            LimitMethod::Bisection => "bisection",
        }
    }
}

/// A place where what is seen of the sources changes its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// Along the line from its first end, metres.
    pub distance: f64,
    /// Metres.
    pub position: DVec3,
    /// On the side of the line's first end.
    pub before: Phase,
    /// On the side of its last end.
    pub after: Phase,
    /// The distance is off by no more than this, metres.
    pub bound: f64,
    /// How it was found.
    pub method: LimitMethod,
}

impl Limit {
    /// What happens on the way along the line: the darker of two neighbours gives the name.
    pub fn name(&self) -> &'static str {
        use Phase::{Antumbra, BelowHorizon, Penumbra, Umbra};
        match (self.before, self.after) {
            (BelowHorizon, _) => "source_rises",
            (_, BelowHorizon) => "source_sets",
            (Umbra, _) => "umbra_ends",
            (_, Umbra) => "umbra_begins",
            (Antumbra, _) => "antumbra_ends",
            (_, Antumbra) => "antumbra_begins",
            (Penumbra, _) => "penumbra_ends",
            _ => "penumbra_begins",
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} at {} m", self.name(), self.distance)
    }
}

/// Every limit along a configuration's measured line, in order.
///
/// The line is that of the configuration's points: straight on a flat receiver, an arc on a sphere.
///
/// - error: each limit's own bound; see [`LimitMethod`]
/// - source: similar triangles and tangent cones for the closed forms, each derived where it stands; second witness:
///   bisection, and table `eclipse_radii`
pub fn limits(configuration: &Configuration) -> Result<Vec<Limit>, NoPath> {
    let path = Path::of(configuration)?;
    Ok(closed::limits(configuration, &path).unwrap_or_else(|| search::limits(configuration, &path)))
}

#[cfg(test)]
mod tests;
