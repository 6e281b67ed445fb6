//! Irradiance behind an optic with an axis: at a point, on a ring, over a rectangle, in all.

use std::f64::consts::PI;

use super::ball::GlassBall;
use super::faces::Loss;
use super::fan::{self, Fan, Knot};
use super::lens::PlanoConvex;
use super::paraboloid::Paraboloid;
use super::slab::Slab;
use super::spherical::SphericalMirror;
use super::{Bounded, OpticsError, beam, glass, length, place, rectangle, stretch};
use crate::number::Wide;
use crate::oracle::quadrature::rule::{self, Demand, Ends};

/// An optic with an axis of symmetry, the light that falls on it, and the level receiver where that light lands.
///
/// The source is a beam along the axis (values are then told over its irradiance E₀, a pure number; powers over E₀ in m²) or,
/// for the slab, a point source (over its intensity I, 1/m²; powers over I in sr). The density by the inverse Jacobian, summed
/// over all rays t that land at the distance ρ from the axis:
///
/// ```text
/// E(ρ) = Σ T(t) g(t)/(ρ |f′(t)|),   f(t) = ±ρ,   2π g dt the incident flux between t and t + dt
/// ```
///
/// (Burkard & Shealy, Appl. Opt. 20, 897, 1981: the flux-tube form.) The rays are found between the map's folds, where it is
/// monotone, and taken to the last bits of numbers of twice the width: next to a caustic, and to a focus, the value keeps its
/// digits for the ρ that is given.
///
/// ```
/// use etendue::oracle::optics::{Arrival, Caustic, Loss};
///
/// // A ball of glass concentrates a beam onto a plane just below it.
/// let ball = Caustic::glass_ball(1.0, 1.5, 1.25, 0.875, Loss::PerPolarisation)?;
/// let Arrival::Finite { value, bound, n_rays } = ball.at(0.0625)? else { panic!("no caustic there") };
/// assert!((value - 10.478_648_012_423_404).abs() < 1e-13 && bound < 1e-12 && n_rays == 1);
/// # Ok::<(), etendue::oracle::optics::OpticsError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Caustic {
    pub(super) optic: Optic,
    pub(super) knots: Vec<Knot>,
}

/// What arrives at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrival {
    /// The light of a number of rays (none: nothing arrives).
    Finite {
        /// Irradiance over that of the beam (of a point source: over its intensity, 1/m²).
        value: f64,
        /// Its error is at most this, for the place as given.
        bound: f64,
        /// How many rays land there.
        n_rays: usize,
    },
    /// The place is nearer to a caustic (a ring where the map folds, or a focus) than 10⁻¹³ of the layout's size: the
    /// irradiance has no bound there, or hangs on the last bits of the place.
    OnCaustic,
}

impl Arrival {
    /// The value, where there is one.
    pub fn value(&self) -> Option<f64> {
        match self {
            Arrival::Finite { value, .. } => Some(*value),
            Arrival::OnCaustic => None,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Optic {
    Paraboloid(Paraboloid),
    Spherical(SphericalMirror),
    Ball(GlassBall),
    Lens(PlanoConvex),
    Slab(Slab),
}

/// Runs one text over whichever optic it is.
macro_rules! with_fan {
    ($optic:expr, $fan:ident => $text:expr) => {
        match $optic {
            Optic::Paraboloid($fan) => $text,
            Optic::Spherical($fan) => $text,
            Optic::Ball($fan) => $text,
            Optic::Lens($fan) => $text,
            Optic::Slab($fan) => $text,
        }
    };
}

#[cfg(test)]
pub(super) use with_fan;

/// Nearer to a caustic than this, in units of the layout's size, a place is on it: 2⁻⁴³.
pub(super) const ON_CAUSTIC: f64 = 1.0 / (1u64 << 43) as f64;
/// Relative error of a landing radius over [`Wide`].
const WIDE_NOISE: f64 = 1e-28;
/// What quadrature of the transmitted share is asked for, relative.
const DEMANDED: f64 = 1e-15;
const MOST_PANELS: usize = 400;

impl Caustic {
    /// A paraboloid z = r²/4f that mirrors a beam along −z, seen on the plane z = `plane`.
    ///
    /// `E/E₀ = (1 − s²)³/(κ² (1 + s²))` with s = r/2f, κ = |1 − z_p/f|; the plane at the focus (z_p = f) gets all power in
    /// one point. Light comes back to the plane only from the part of the mirror below it.
    ///
    /// - `focal_length` f, `plane` z_p: metres, > 0; `beam_radius`: metres, in (0, 2f); all finite
    /// - source: all rays pass the focus; table `caustic_paraboloid`
    pub fn paraboloid(focal_length: f64, plane: f64, beam_radius: f64) -> Result<Caustic, OpticsError> {
        let focal_length = length("the focal length", focal_length)?;
        let plane = length("the plane's height", plane)?;
        let beam_radius = beam(beam_radius, 2.0 * focal_length, false)?;
        Ok(Caustic::of(Optic::Paraboloid(Paraboloid { focal_length, plane, beam_radius })))
    }

    /// A spherical mirror with its vertex at z = 0 that mirrors a beam along −z, seen on the plane z = `plane`.
    ///
    /// Light comes back to the plane only from the part of the mirror below it.
    ///
    /// - `radius` R, `plane`: metres, > 0; `beam_radius`: metres, in (0, R/√2), since from farther out light is mirrored
    ///   downwards; all finite
    /// - source: the ray at the angle t from the axis leaves at 2t; table `caustic_spherical_mirror`
    pub fn spherical_mirror(radius: f64, plane: f64, beam_radius: f64) -> Result<Caustic, OpticsError> {
        let radius = length("the mirror's radius", radius)?;
        let plane = length("the plane's height", plane)?;
        let beam_radius = beam(beam_radius, radius * std::f64::consts::FRAC_1_SQRT_2, false)?;
        Ok(Caustic::of(Optic::Spherical(SphericalMirror { radius, plane, beam_radius })))
    }

    /// A ball of glass around the origin in a beam along −z, seen on the plane z = −`distance`, after one passage.
    ///
    /// Rays turned by a right angle or more never land, and are not in [`Caustic::total`].
    ///
    /// - `radius` R: metres, > 0; `index`: in [1, 10³]; `distance`: metres, ≥ R; `beam_radius`: metres, in (0, R]
    /// - source: Snell's law at both faces, one plane of incidence; table `caustic_ball_lens`
    pub fn glass_ball(
        radius: f64,
        index: f64,
        distance: f64,
        beam_radius: f64,
        loss: Loss,
    ) -> Result<Caustic, OpticsError> {
        let radius = length("the ball's radius", radius)?;
        let distance = length("the plane's distance", distance)?;
        if distance < radius {
            return Err(OpticsError::InsideGlass { said: distance, radius });
        }
        let beam_radius = beam(beam_radius, radius, true)?;
        Ok(Caustic::of(Optic::Ball(GlassBall { radius, index: glass(index)?, distance, beam_radius, loss })))
    }

    /// A plano-convex lens, flat face towards a beam along −z, the vertex of the other at z = 0, seen on z = −`distance`.
    ///
    /// Rays beyond the radius R/n stay in the glass, and are not in [`Caustic::total`].
    ///
    /// - `radius` of curvature R: metres, > 0; `index`: in [1, 10³]; `distance`: metres, > 0; `beam_radius`: metres, in (0, R]
    /// - source: Snell's law at the curved face; table `caustic_plano_convex`
    pub fn plano_convex(
        radius: f64,
        index: f64,
        distance: f64,
        beam_radius: f64,
        loss: Loss,
    ) -> Result<Caustic, OpticsError> {
        let radius = length("the radius of curvature", radius)?;
        let distance = length("the plane's distance", distance)?;
        let beam_radius = beam(beam_radius, radius, true)?;
        Ok(Caustic::of(Optic::Lens(PlanoConvex { radius, index: glass(index)?, distance, beam_radius, loss })))
    }

    /// A level slab of glass between a point source and a level receiver; the light that leaves it after 2 `echoes`
    /// reflections inside.
    ///
    /// No caustic: the source's image is blurred along the axis. Straight below, `E/I → T/(h + d/n)²`.
    ///
    /// - `air` h: of the whole way, above and below the slab, metres, > 0; `thickness` d: metres, > 0; `index`: in [1, 10³]
    /// - values are over the intensity, 1/m²; powers in sr
    /// - source: the shift of the virtual image; table `caustic_slab_point_source`
    pub fn slab_under_point_source(
        air: f64,
        thickness: f64,
        index: f64,
        echoes: u32,
        loss: Loss,
    ) -> Result<Caustic, OpticsError> {
        let (air, thickness) = (length("the way in air", air)?, length("the slab's thickness", thickness)?);
        Ok(Caustic::of(Optic::Slab(Slab { air, thickness, index: glass(index)?, echoes, loss })))
    }

    fn of(optic: Optic) -> Caustic {
        let knots = with_fan!(&optic, fan => fan::knots(fan));
        Caustic { optic, knots }
    }

    /// Radii of the ring caustics, metres, from the axis outwards.
    ///
    /// A focus on the axis is none of them; [`Caustic::is_focused`] tells.
    pub fn rings(&self) -> Vec<f64> {
        let folds = self.knots.iter().filter(|knot| knot.is_fold);
        let mut radii: Vec<f64> = folds.map(|knot| knot.landing.narrow().abs()).collect();
        radii.sort_by(f64::total_cmp);
        radii
    }

    /// Radii where the irradiance jumps or has no bound, metres: ring caustics, and the images of the axis and of the last ray.
    pub fn edges(&self) -> Vec<f64> {
        let mut radii: Vec<f64> = self.knots.iter().map(|knot| knot.landing.narrow().abs()).collect();
        radii.sort_by(f64::total_cmp);
        radii
    }

    /// Whether light of rays away from the axis meets on it, so that the irradiance has no bound there.
    pub fn is_focused(&self) -> bool {
        let is_flat = with_fan!(&self.optic, fan => {
            fan::landing_jet(fan, Wide::ZERO)[1].narrow().abs() <= ON_CAUSTIC * fan.size()
        });
        is_flat || self.axis_rays().iter().any(|u| u.narrow() > 0.0)
    }

    fn axis_rays(&self) -> impl std::ops::Deref<Target = [Wide]> {
        with_fan!(&self.optic, fan => fan::preimages(fan, &self.knots, 0.0, |u| u))
    }

    /// Whether all rays land in one point.
    fn is_point(&self) -> bool {
        self.knots.iter().all(|knot| knot.landing.narrow() == 0.0)
    }

    /// What arrives at a distance from the axis.
    ///
    /// The beam's rim is sharp; a place on its image counts as lit.
    ///
    /// - `radius` ρ: metres, finite, ≥ 0
    /// - error: `bound`, in general 5·10⁻¹⁵ relative, for the ρ and the layout as given (a change of ρ by one bit may do more)
    pub fn at(&self, radius: f64) -> Result<Arrival, OpticsError> {
        let radius = place("the radius", radius)?;
        if radius < 0.0 {
            return Err(OpticsError::Place { field: "the radius", said: radius });
        }
        Ok(with_fan!(&self.optic, fan => self.density(fan, radius)))
    }

    fn density<F: Fan>(&self, fan: &F, radius: f64) -> Arrival {
        let near = ON_CAUSTIC * fan.size();
        let nothing = Arrival::Finite { value: 0.0, bound: 0.0, n_rays: 0 };
        if self.is_point() {
            return if radius <= near { Arrival::OnCaustic } else { nothing };
        }
        let is_near = |knot: &Knot| {
            let off = if knot.landing.narrow() < 0.0 {
                knot.landing + Wide::from(radius)
            } else {
                knot.landing - Wide::from(radius)
            };
            knot.is_fold && off.narrow().abs() <= near
        };
        if self.knots.iter().any(is_near) || (radius <= near && self.is_focused()) {
            return Arrival::OnCaustic;
        }
        let (mut value, mut bound, mut n_rays) = (0.0, 0.0, 0);
        for u in fan::preimages(fan, &self.knots, radius, |u| u) {
            let [_, slope, bend] = fan::landing_jet(fan, u);
            let [_, flux_slope, flux_bend] = fan::second_jet(|u| fan.flux(u), u);
            let term = if radius > 0.0 {
                (flux_slope / (slope * radius)).narrow().abs()
            } else {
                // On the axis flux and landing radius grow from nothing: as u²/2 and as u.
                (flux_bend / slope.square()).narrow().abs()
            } * fan.share(u.narrow());
            let steep = (slope.narrow() / fan.size()).abs();
            let blur = WIDE_NOISE * (1.0 + (bend.narrow() / fan.size()).abs() / steep) / steep;
            value += term;
            bound += term * (super::ROUNDINGS * f64::EPSILON + blur);
            n_rays += 1;
        }
        if value.is_finite() && bound.is_finite() {
            Arrival::Finite { value, bound, n_rays }
        } else {
            Arrival::OnCaustic
        }
    }

    /// Power that lands between two circles around the axis: finite everywhere.
    ///
    /// ```text
    /// P = Σ ∫ 2π g T dt   over the stretches of rays with ρ₀ ≤ |f(t)| < ρ₁
    /// ```
    ///
    /// - `from` ρ₀, `to` ρ₁: metres, 0 ≤ ρ₀ ≤ ρ₁; ρ₁ may be infinite
    /// - returns m² over the beam's irradiance (a point source: sr over its intensity)
    /// - error: `bound`, in general some 10⁻¹⁵ relative; without losses it is a difference of areas
    /// - source: flux is kept along a tube of rays; table `caustic_bins`
    pub fn power_in_ring(&self, from: f64, to: f64) -> Result<Bounded, OpticsError> {
        let [from, to] = stretch("the ring", [from, to])?;
        if from < 0.0 {
            return Err(OpticsError::Place { field: "the ring", said: from });
        }
        Ok(with_fan!(&self.optic, fan => self.ring(fan, [from, to])))
    }

    fn ring<F: Fan>(&self, fan: &F, [from, to]: [f64; 2]) -> Bounded {
        let ends = [self.knots[0].u, self.knots[self.knots.len() - 1].u];
        let mut cuts = ends.to_vec();
        if !self.is_point() {
            let bounds = [from, to].into_iter().filter(|radius| *radius > 0.0 && radius.is_finite());
            cuts.extend(bounds.flat_map(|radius| fan::preimages(fan, &self.knots, radius, |u| u)));
        }
        cuts.sort_by(|a, b| (*a - *b).narrow().total_cmp(&0.0));
        let mut sum = Bounded::default();
        for pair in cuts.windows(2) {
            let middle = (pair[0] + pair[1]) * 0.5;
            let landing = fan.landing(middle).narrow().abs();
            if landing >= from && landing < to {
                let part = between(fan, [pair[0], pair[1]]);
                sum.value += part.value;
                sum.bound += part.bound;
            }
        }
        sum
    }

    /// Power that lands in a rectangle of the receiver, wherever it lies: finite everywhere.
    ///
    /// Every ray stands for a circle of rays; of its flux the rectangle gets the share of the circle's arc within:
    ///
    /// ```text
    /// P = ∫ α(|f(t)|) g T dt,   α(ρ) the angle under which the circle of radius ρ lies in the rectangle
    /// ```
    ///
    /// - `x`, `y`: its sides' coordinates from the axis, metres, finite, each in order
    /// - returns m² over the beam's irradiance (a point source: sr over its intensity)
    /// - error: `bound`, from the rule of quadrature; in general below 10⁻¹³ of what lands on the circles that it meets
    /// - source: flux is kept along a tube of rays; second witness: rings, and quadrature of [`Caustic::at`]
    pub fn power_in_rectangle(&self, x: [f64; 2], y: [f64; 2]) -> Result<Bounded, OpticsError> {
        let sides = [stretch("x", x)?, stretch("y", y)?];
        for [_, to] in sides {
            place("a side", to)?;
        }
        Ok(with_fan!(&self.optic, fan => rectangle::power(fan, &self.knots, self.is_point(), sides)))
    }

    /// Power that lands anywhere on the plane: m² over the beam's irradiance (a point source: sr over its intensity).
    ///
    /// - error: `bound`, some 10⁻¹⁵ relative
    pub fn total(&self) -> Bounded {
        with_fan!(&self.optic, fan => between(fan, [Wide::ZERO, fan.last()]))
    }

    /// Power that falls on the optic: of a beam its cross-section π b², m²; of a point source above a slab 2π sr.
    pub fn incident(&self) -> f64 {
        let beam_radius = match self.optic {
            Optic::Paraboloid(mirror) => mirror.beam_radius,
            Optic::Spherical(mirror) => mirror.beam_radius,
            Optic::Ball(ball) => ball.beam_radius,
            Optic::Lens(lens) => lens.beam_radius,
            Optic::Slab(_) => std::f64::consts::SQRT_2,
        };
        PI * beam_radius * beam_radius
    }
}

/// ∫ 2π g T dt between two rays.
fn between<F: Fan>(fan: &F, [from, to]: [Wide; 2]) -> Bounded {
    if fan.is_lossless() {
        let flux = (fan.flux(to) - fan.flux(from)).narrow();
        return Bounded::rounded(2.0 * PI * flux.max(0.0) * fan.share(0.0));
    }
    // From the middle outwards: a thin ring's width is known to all its digits.
    let (middle, half) = (((from + to) * 0.5).narrow(), ((to - from) * 0.5).narrow());
    if half <= 0.0 {
        return Bounded::default();
    }
    let integrand = |x: f64| {
        let u = middle + half * x;
        let (_, slope) = fan::jet(|u| fan.flux(u), u);
        [slope * fan.share(u)]
    };
    let demand = |sum: &[f64; 1]| Demand { goal: [DEMANDED * sum[0].abs()], floor: |value| [1e-17 * value[0].abs()] };
    let found = rule::integrate(&[-1.0, 1.0], Ends::Smooth, 1e-9, MOST_PANELS, integrand, demand);
    let scale = 2.0 * PI * half;
    let value = scale * found.value[0];
    Bounded { value, bound: scale * found.error[0] + Bounded::rounded(value).bound }
}
