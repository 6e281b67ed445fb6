//! How rays are sent from the light.

use crate::geometry::{DVec3, TexelGrid};

/// Where rays are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aim {
    /// Most of them towards mirrors and glass, by the solid angle of spheres around them; some elsewhere, each weighed so
    /// that nothing is lost.
    Optics,
    /// As the source emits.
    Nowhere,
}

impl Aim {
    /// All, in the order of their names' table.
    pub const ALL: [Aim; 2] = [Aim::Optics, Aim::Nowhere];
    /// The name that a case file uses.
    pub fn name(self) -> &'static str {
        match self {
            Aim::Optics => "optics",
            Aim::Nowhere => "nowhere",
        }
    }
}

/// What becomes of a ray at a face of glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// It goes on whole, reflected with a probability of the reflected share, else refracted: packets keep their size.
    One,
    /// Both parts are followed, each with its share. Below 2⁻¹⁰ of a ray's first flux one of them is chosen.
    Both,
}

impl Split {
    /// All, in the order of their names' table.
    pub const ALL: [Split; 2] = [Split::One, Split::Both];
    /// The name that a case file uses.
    pub fn name(self) -> &'static str {
        match self {
            Split::One => "one",
            Split::Both => "both",
        }
    }
}

/// Rings on the receiver in which light is counted by its number of interactions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rings {
    /// Metres.
    pub center: DVec3,
    /// Outer radius of the last ring, metres, > 0.
    pub radius: f64,
    /// Rings of equal width, from 1 to [`Rings::MOST`].
    pub count: usize,
}

impl Rings {
    /// Most rings.
    pub const MOST: usize = 4096;
    /// Inner and outer radius of a ring, metres.
    pub fn radii(&self, ring: usize) -> [f64; 2] {
        [ring, ring + 1].map(|k| self.radius * k as f64 / self.count as f64)
    }
}

/// How light is followed from its sources.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSettings {
    /// Rays that leave the sources, at least; ≥ 1. A few more may leave, to fill the last group.
    pub rays: u64,
    /// Texels along s and t of the map of the receiver and of each diffuse surface; each from 1 to
    /// [`LightSettings::MOST_TEXELS`], as is their product.
    pub map: [usize; 2],
    /// Most interactions with mirrors and glass on one path, from 0 to [`LightSettings::MOST_DEPTH`]. What would have more is
    /// booked as terminated.
    pub depth: usize,
    pub aim: Aim,
    pub split: Split,
    /// On the receiver; `None`: light is not counted in rings.
    pub rings: Option<Rings>,
    /// Tiles of the receiver along s and t in which light is counted by its number of interactions, at most [`Rings::MOST`].
    pub tiles: Option<TexelGrid>,
}

impl LightSettings {
    /// Most texels of one map.
    pub const MOST_TEXELS: usize = 1 << 20;
    /// Largest depth limit.
    pub const MOST_DEPTH: usize = 256;
    /// Most rays.
    pub const MOST_RAYS: u64 = 1 << 40;
}

impl Default for LightSettings {
    fn default() -> LightSettings {
        LightSettings {
            rays: 1_000_000,
            map: [64, 64],
            depth: 16,
            aim: Aim::Optics,
            split: Split::One,
            rings: None,
            tiles: None,
        }
    }
}
