//! Light that takes a bend, exactly: mirrors, glass, and surfaces that light each other.
//!
//! | question | answer |
//! |---|---|
//! | what one face, two faces, a slab or a ball lets through, polarisations apart | [`faces`] |
//! | irradiance behind a curved mirror, a ball, a lens, a slab; power in a ring or a rectangle | [`Caustic`] |
//! | the pattern in a cup: a half cylinder that mirrors inwards | [`CylinderMirror`] |
//! | an area source seen in a flat mirror, past occluders | [`MirrorOracle`] |
//! | a room with a flat mirror that shows all, as a room without | [`unfolded`] |
//! | two disks, two rectangles that light each other | [`CoaxialDisks`], [`FacingRectangles`] |
//! | a bulb in a shell that scatters what it lets through | [`Lampshade`] |
//! | a whole room: light by the way that it has come, as far as it is known | [`RoomLight`] |
//!
//! Closed surfaces that light themselves, and endless plates, are in [`crate::radiometry::enclosure`]; Fresnel's equations
//! at one face and their diffuse means in [`crate::radiometry`].
//!
//! # Where a caustic has no value
//!
//! On the caustic itself the irradiance has no bound. There the answer is [`Arrival::OnCaustic`], never an infinity; what a
//! receiver of some size gets is finite everywhere, and is what [`Caustic::power_in_ring`] and its kin tell.
//!
//! # One path each
//!
//! These layouts follow one interaction order: one reflection, or one passage through the glass without an echo (a slab: any
//! number of echoes, one at a time). The receiver does not stand in the way of the light that falls in.

mod ball;
mod between;
mod caustic;
mod cup;
mod cylinder;
mod deposit;
mod disks;
mod exchange;
pub mod faces;
mod fan;
mod inside;
mod lampshade;
mod layout;
mod lens;
mod meridian;
mod mirror;
mod nodes;
mod paraboloid;
mod rectangle;
mod rectangles;
mod room;
mod shade;
mod slab;
mod spherical;
mod unfold;

#[cfg(test)]
mod tests;

use thiserror::Error;

use crate::geometry::ShapeError;
use crate::radiometry::RadiometryError;

pub use caustic::{Arrival, Caustic};
pub use cup::CupLayout;
pub use cylinder::CylinderMirror;
pub use deposit::{DepositedPower, deposited_power};
pub use disks::CoaxialDisks;
pub use exchange::Which;
pub use faces::{Loss, Polarised};
pub use lampshade::Lampshade;
pub use layout::{CausticLayout, flat_mirror, power_by_flat_mirror};
pub use mirror::{MirrorOracle, MirrorTruth, PlaneMirror};
pub use rectangles::FacingRectangles;
pub use room::{Arriving, RoomLight, Way};
pub use shade::{power_by_lampshade, power_through_two_spheres};
pub use unfold::unfolded;

/// A number and what it is off by at most.
///
/// The unit is that of the question. The bound counts rounding and the estimated error of quadrature; it is an estimate,
/// not a proof, where quadrature takes part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bounded {
    /// The value.
    pub value: f64,
    /// Its error is at most this, in the same unit.
    pub bound: f64,
}

impl Bounded {
    /// A value known to a few roundings.
    pub(super) fn rounded(value: f64) -> Bounded {
        Bounded { value, bound: ROUNDINGS * f64::EPSILON * value.abs() }
    }
    /// Both times a factor.
    pub fn scaled(self, factor: f64) -> Bounded {
        Bounded { value: self.value * factor, bound: self.bound * factor.abs() }
    }
}

/// Rounding steps behind a result, in units of `f64::EPSILON`.
const ROUNDINGS: f64 = 24.0;

/// Why an optical layout, or a question to it, was refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OpticsError {
    /// A length that is none.
    #[error("{field} is {said}; it is finite and greater than zero (metres)")]
    Length {
        /// Which of the arguments.
        field: &'static str,
        /// Its value.
        said: f64,
    },
    /// A beam wider than the optic takes.
    #[error("the beam's radius is {said} m; this optic takes no more than {limit} m")]
    Beam {
        /// Its value, metres.
        said: f64,
        /// What it has to stay below (or, of glass, reach), metres.
        limit: f64,
    },
    /// A refractive index outside the domain.
    #[error("the refractive index is {said}; glass in air has an index from 1 to 1e3")]
    Index {
        /// Its value.
        said: f64,
    },
    /// A receiver inside the optic.
    #[error("the receiver lies {said} m from the middle of a ball of radius {radius} m; it lies beyond the glass")]
    InsideGlass {
        /// Its distance, metres.
        said: f64,
        /// The ball's radius, metres.
        radius: f64,
    },
    /// A coordinate that is none.
    #[error("{field} is {said}; coordinates are finite numbers, radii zero or greater")]
    Place {
        /// Which of the arguments.
        field: &'static str,
        /// Its value.
        said: f64,
    },
    /// A stretch that ends before it begins.
    #[error("the stretch runs from {from} to {to}; it begins where it is lower")]
    Stretch {
        /// Its first end, metres.
        from: f64,
        /// Its second end, metres.
        to: f64,
    },
    /// A share that is none.
    #[error("{field} is {said}; a share lies between 0 and 1")]
    Share {
        /// Which of the arguments.
        field: &'static str,
        /// Its value.
        said: f64,
    },
    /// Light that never dies out, or more light sent on than has come.
    #[error("{said} of the light is sent on; surfaces that light each other lose some")]
    NothingLost {
        /// The sum of the shares, or the share sent round once.
        said: f64,
    },
    /// Surfaces too near to each other for their size.
    #[error("the surfaces are {ratio:.3e} times as large as they are apart; up to {limit} is solved for")]
    TooClose {
        /// Size over distance.
        ratio: f64,
        /// The largest that is taken.
        limit: f64,
    },
    /// A shape that is no mirror.
    #[error("a flat mirror is a disk, a rectangle or a polygon, not a {said}")]
    MirrorShape {
        /// The name of its kind.
        said: &'static str,
    },
    /// A receiver on the mirror.
    #[error("the point lies in the mirror's plane, where it sees no reflection")]
    InMirrorPlane,
    /// A sphere source and something that cuts into it, or the mirror's edge in it.
    #[error(
        "occluder {occluder} (counted from 0; sources after the occluders) cuts into sphere source {said}: no outline of directions tells what is before what"
    )]
    CutsIntoSource {
        /// Which source.
        said: usize,
        /// Which occluder.
        occluder: usize,
    },
    /// An occluder that two planes cut.
    #[error(
        "occluder {said} (counted from 0; sources after the occluders) reaches through the mirror's plane and through the source's: cut it in two"
    )]
    TwiceCut {
        /// Which occluder.
        said: usize,
    },
    /// A bulb that is not inside its shell.
    #[error("the bulb is {said} m from the middle of a shell of radius {radius} m; it is nearer than that")]
    OutsideShell {
        /// Its distance, metres.
        said: f64,
        /// The shell's radius, metres.
        radius: f64,
    },
    /// A surface that is none, or a point on one.
    #[error("{said}")]
    Configuration {
        /// What is wrong, in words.
        said: String,
    },
    /// What is wrong with a shape.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// What is wrong with a quantity.
    #[error(transparent)]
    Radiometry(#[from] RadiometryError),
}

/// A finite length greater than zero.
fn length(field: &'static str, said: f64) -> Result<f64, OpticsError> {
    if said.is_finite() && said > 0.0 { Ok(said) } else { Err(OpticsError::Length { field, said }) }
}

/// A beam that an optic takes: narrower than a limit, or as wide.
fn beam(said: f64, limit: f64, may_touch: bool) -> Result<f64, OpticsError> {
    let said = length("the beam's radius", said)?;
    if said < limit || (may_touch && said == limit) { Ok(said) } else { Err(OpticsError::Beam { said, limit }) }
}

/// The index of glass in air.
fn glass(said: f64) -> Result<f64, OpticsError> {
    if (1.0..=1e3).contains(&said) { Ok(said) } else { Err(OpticsError::Index { said }) }
}

/// A share in [0, 1].
fn share(field: &'static str, said: f64) -> Result<f64, OpticsError> {
    if (0.0..=1.0).contains(&said) { Ok(said) } else { Err(OpticsError::Share { field, said }) }
}

/// A finite coordinate.
fn place(field: &'static str, said: f64) -> Result<f64, OpticsError> {
    if said.is_finite() { Ok(said) } else { Err(OpticsError::Place { field, said }) }
}

/// Finite, and in order.
fn stretch(field: &'static str, [from, to]: [f64; 2]) -> Result<[f64; 2], OpticsError> {
    place(field, from)?;
    // Endless on the far side is no mistake for a ring.
    if to.is_nan() {
        return Err(OpticsError::Place { field, said: to });
    }
    if from <= to { Ok([from, to]) } else { Err(OpticsError::Stretch { from, to }) }
}
