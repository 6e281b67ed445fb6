//! What the exact side says of one measurement point.

use std::fmt;

use crate::radiometry::{FormFactor, Irradiance};

/// How much of the sources a point sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Region {
    /// Sees every source wholly.
    Lit,
    /// Sees some part of the sources, but not all of them: an occluder or the point's own horizon cuts them.
    Penumbra,
    /// Sees nothing, because occluders hide what is above the horizon.
    Umbra,
    /// Every source lies below the point's horizon or turns its dark side.
    BelowHorizon,
    /// Cannot be told within the stated bound.
    Edge,
}

impl Region {
    pub const ALL: [Region; 5] = [Region::Lit, Region::Penumbra, Region::Umbra, Region::BelowHorizon, Region::Edge];

    /// The name that reports use.
    pub fn name(self) -> &'static str {
        match self {
            Region::Lit => "lit",
            Region::Penumbra => "penumbra",
            Region::Umbra => "umbra",
            Region::BelowHorizon => "below_horizon",
            Region::Edge => "edge",
        }
    }
    /// The other way round.
    pub fn from_name(name: &str) -> Option<Region> {
        Region::ALL.into_iter().find(|region| region.name() == name)
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// How a point sees one source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Sight {
    Whole,
    Part,
    Hidden,
    Below,
    /// Whether it is whole (or hidden) or only in part is below the bound.
    Unclear,
}

impl Region {
    /// Of all sources together.
    pub(super) fn of(sights: impl Iterator<Item = Sight> + Clone) -> Region {
        let all = |accepted: &[Sight]| sights.clone().all(|sight| accepted.contains(&sight));
        if all(&[Sight::Whole]) {
            Region::Lit
        } else if all(&[Sight::Below]) {
            Region::BelowHorizon
        } else if all(&[Sight::Hidden, Sight::Below]) {
            Region::Umbra
        } else if all(&[Sight::Whole, Sight::Unclear]) || all(&[Sight::Hidden, Sight::Below, Sight::Unclear]) {
            Region::Edge
        } else {
            Region::Penumbra
        }
    }
}

/// How an exact value was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub enum Method {
    /// A sum of closed-form contour integrals.
    ClosedForm,
    /// Deterministic adaptive quadrature.
    Quadrature,
}

impl Method {
    /// The name that reports use.
    pub fn name(self) -> &'static str {
        match self {
            Method::ClosedForm => "closed-form",
            Method::Quadrature => "quadrature",
        }
    }
}

/// The exact irradiance at one point, with what is known of it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Truth {
    /// Of all sources together, each weighed by its exitance; W/m².
    pub irradiance: Irradiance,
    /// The same without the occluders (and without the other sources in the way); W/m².
    pub unoccluded_irradiance: Irradiance,
    /// Of the visible parts of all sources together, with exitance 1; a pure number.
    pub form_factor: FormFactor,
    /// The irradiance is off by no more than this; W/m². Zero only where the value is zero by classification.
    pub bound: Irradiance,
    /// How much of the sources the point sees.
    pub region: Region,
    /// How the value was found; quadrature if any source needed it.
    pub method: Method,
    /// Whether the outline of an occluder (or of another source) runs across a visible source: an estimator's
    /// integrand then jumps, and stratification gains less.
    pub shadow_edge: bool,
}
