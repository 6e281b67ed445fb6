//! Textures: what varies over a surface and is looked up at a point of it, exitance (W/m²) or albedo.
//!
//! A [`Texture`] is a surface's [map](crate::geometry::Parametrisation) with values on its texels ([`Texels`]), or a
//! polynomial over a rectangle ([`ExitancePolynomial`]). Both sides of the trial read it: the estimates at the places that
//! they draw, the exact side as a sum over texels, or by quadrature between the [seams](Texture::seams). It is shared ground,
//! and its laws are tested here: the integral over the surface is the sum over texels of value × area, for either lookup.

mod axis;
mod polynomial;
mod raster;
mod texels;
mod triangle;

use glam::DVec3;

use crate::errors::errors;
use crate::geometry::{ParametrisationError, Rectangle};

use polynomial::Edges;
pub use polynomial::ExitancePolynomial;
pub use raster::{Encoding, Raster};
pub use texels::{Lookup, Texels};

errors! {
    /// Why there is no such texture.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum TextureError {
        #[error(transparent)]
        Map(#[from] ParametrisationError),
        #[error("{said} values for {expected} texels")]
        Length { said: usize, expected: usize },
        #[error("the value of texel ({i}, {j}) is {said}; every value is a finite number, zero or greater")]
        Value { i: usize, j: usize, said: f64 },
        #[error("the polynomial falls to {least} on the rectangle; what a surface sends out is zero or greater")]
        Negative { least: f64 },
        #[error("the polynomial is {said} on the rectangle; every value is a finite number")]
        NotFinite { said: f64 },
        #[error("nothing is sent out: every texel of the surface is zero")]
        Dark,
    }
}

/// A value at every point of a surface.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Texture {
    /// Values on the texels of the surface's map.
    Texels(Texels),
    /// A polynomial over a rectangle.
    Polynomial(OnRectangle),
}

/// A polynomial on its rectangle, nowhere negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnRectangle {
    rectangle: Rectangle,
    edges: Edges,
    polynomial: ExitancePolynomial,
    least: f64,
    largest: f64,
}

impl OnRectangle {
    /// - an error where it is negative anywhere on the rectangle
    pub fn new(rectangle: Rectangle, polynomial: ExitancePolynomial) -> Result<OnRectangle, TextureError> {
        let [least, largest] = polynomial.range(&rectangle);
        if !(least.is_finite() && largest.is_finite()) {
            return Err(TextureError::NotFinite { said: if least.is_finite() { largest } else { least } });
        }
        // A zero that rounding takes for less is zero.
        if least < -1e-12 * largest.max(0.0) || (least < 0.0 && largest <= 0.0) {
            return Err(TextureError::Negative { least });
        }
        Ok(OnRectangle { rectangle, edges: Edges::new(&rectangle), polynomial, least: least.max(0.0), largest })
    }
    pub fn rectangle(&self) -> &Rectangle {
        &self.rectangle
    }
    pub fn polynomial(&self) -> &ExitancePolynomial {
        &self.polynomial
    }
}

/// Where a texture is not smooth, in the coordinates of its map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seams {
    /// Lines of one s, each in [0, 1], ascending.
    pub s: Vec<f64>,
    /// Lines of one t.
    pub t: Vec<f64>,
    /// Whether the texture is constant between them.
    pub is_constant_between: bool,
}

impl Texture {
    /// The value at a point of the surface (metres); beside it, that of the nearest point, as the map takes it.
    #[inline]
    pub fn at(&self, point: DVec3) -> f64 {
        self.at_offset(point - self.anchor())
    }

    /// A point of the surface, metres: the [anchor](crate::geometry::Parametrisation::anchor) of the map, the centre of a
    /// polynomial's rectangle.
    #[inline]
    pub fn anchor(&self) -> DVec3 {
        match self {
            Texture::Texels(texels) => texels.map().anchor(),
            Texture::Polynomial(on) => on.rectangle.center(),
        }
    }

    /// The value at a point given by its offset from the [anchor](Texture::anchor), metres: far from the origin, with digits
    /// that coordinates have lost.
    #[inline]
    pub fn at_offset(&self, offset: DVec3) -> f64 {
        match self {
            Texture::Texels(texels) => texels.at_offset(offset),
            Texture::Polynomial(on) => {
                let [s, t] = on.edges.metres(offset);
                on.polynomial.value(s, t).max(0.0)
            }
        }
    }

    /// Its integral over the surface, exactly: of exitance, all the power that is sent out, W.
    pub fn integral(&self) -> f64 {
        match self {
            Texture::Texels(texels) => texels.integral(),
            Texture::Polynomial(on) => on.polynomial.mean(&on.rectangle) * on.rectangle.area(),
        }
    }

    /// Its mean over the surface.
    pub fn mean(&self) -> f64 {
        match self {
            Texture::Texels(texels) => texels.integral() / texels.map().area(),
            Texture::Polynomial(on) => on.polynomial.mean(&on.rectangle),
        }
    }

    /// No value on the surface is less than the first or greater than the second.
    pub fn range(&self) -> [f64; 2] {
        match self {
            Texture::Texels(texels) => texels.range(),
            Texture::Polynomial(on) => [on.least, on.largest],
        }
    }

    /// Where it is not smooth.
    pub fn seams(&self) -> Seams {
        match self {
            Texture::Texels(texels) => texels.seams(),
            Texture::Polynomial(_) => Seams::default(),
        }
    }

    /// The texels, if it is made of such.
    pub fn texels(&self) -> Option<&Texels> {
        match self {
            Texture::Texels(texels) => Some(texels),
            Texture::Polynomial(_) => None,
        }
    }
}

#[cfg(test)]
mod tests;
