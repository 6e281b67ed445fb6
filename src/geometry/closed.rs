//! Closed convex bodies that pieces of glass have, besides the sphere: slabs and plano-convex lenses.

use glam::DVec3;

use super::shape::{Rectangle, ShapeError, finite, positive, unit};

/// A rectangular plate with two large faces and four narrow ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    middle: Rectangle,
    thickness: f64,
}

impl Slab {
    /// - `middle`: the rectangle half-way between the large faces; `thickness`: along its normal, metres, > 0
    pub fn new(middle: Rectangle, thickness: f64) -> Result<Slab, ShapeError> {
        Ok(Slab { middle, thickness: positive("thickness", thickness)? })
    }
    /// The rectangle half-way between the large faces.
    pub fn middle(&self) -> Rectangle {
        self.middle
    }
    /// Metres.
    pub fn thickness(&self) -> f64 {
        self.thickness
    }
    /// All six faces, square metres.
    pub fn area(&self) -> f64 {
        let round = self.middle.edge_u().length() + self.middle.edge_v().length();
        2.0 * (self.middle.area() + round * self.thickness)
    }
    /// A sphere through the corners (through the farther ones, if edges are off the right angle).
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        let (u, v) = (self.middle.edge_u() * 0.5, self.middle.edge_v() * 0.5);
        let across = (u + v).length().max((u - v).length());
        (self.middle.center(), across.hypot(0.5 * self.thickness))
    }
    /// The faces as rectangles with normals outwards.
    pub fn faces(&self) -> Vec<Rectangle> {
        let (u, v) = (self.middle.edge_u(), self.middle.edge_v());
        let w = self.middle.normal() * self.thickness;
        let face = |offset: DVec3, a: DVec3, b: DVec3| {
            Rectangle::new(self.middle.center() + offset * 0.5, a, b)
                .expect("edges of a valid slab are perpendicular")
        };
        vec![face(w, u, v), face(-w, v, u), face(u, v, w), face(-u, w, v), face(v, w, u), face(-v, u, w)]
    }
}

/// A lens with one flat face: the part of a ball beyond a plane, at most half of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanoConvex {
    vertex: DVec3,
    axis: DVec3,
    curvature_radius: f64,
    rim_radius: f64,
}

impl PlanoConvex {
    /// - `vertex`: the middle of the curved face, metres; `axis`: from there to the flat face, any length but zero
    /// - `curvature_radius`: of the curved face; `rim_radius`: of the flat one, at most as large; metres, > 0
    pub fn new(
        vertex: DVec3,
        axis: DVec3,
        curvature_radius: f64,
        rim_radius: f64,
    ) -> Result<PlanoConvex, ShapeError> {
        let lens = PlanoConvex {
            vertex: finite("vertex", vertex)?,
            axis: unit("axis", axis)?,
            curvature_radius: positive("curvature_radius", curvature_radius)?,
            rim_radius: positive("rim_radius", rim_radius)?,
        };
        if rim_radius > curvature_radius {
            return Err(ShapeError::TooWide { field: "rim_radius", said: rim_radius, most: curvature_radius });
        }
        Ok(lens)
    }
    /// Metres.
    pub fn vertex(&self) -> DVec3 {
        self.vertex
    }
    /// Unit vector from the vertex to the flat face.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }
    /// Metres.
    pub fn curvature_radius(&self) -> f64 {
        self.curvature_radius
    }
    /// Metres.
    pub fn rim_radius(&self) -> f64 {
        self.rim_radius
    }
    /// Centre of the curved face's sphere, metres.
    pub fn curvature_center(&self) -> DVec3 {
        self.vertex + self.axis * self.curvature_radius
    }
    /// Distance from the vertex to the flat face, R − √(R² − a²), metres.
    pub fn thickness(&self) -> f64 {
        let (radius, rim) = (self.curvature_radius, self.rim_radius);
        rim * rim / (radius + ((radius - rim) * (radius + rim)).sqrt())
    }
    /// Both faces, square metres.
    pub fn area(&self) -> f64 {
        let pi = std::f64::consts::PI;
        2.0 * pi * self.curvature_radius * self.thickness() + pi * self.rim_radius * self.rim_radius
    }
    /// A sphere that holds the lens: about the middle of the flat face, as wide as the rim.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        (self.vertex + self.axis * self.thickness(), self.rim_radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_slab_is_closed_by_its_faces() {
        let middle = Rectangle::new(DVec3::ONE, DVec3::X * 2.0, DVec3::new(0.0, 3.0, 4.0)).unwrap();
        let slab = Slab::new(middle, 0.5).unwrap();
        let faces = slab.faces();
        let area: f64 = faces.iter().map(Rectangle::area).sum();
        assert_relative_eq!(area, slab.area(), max_relative = 1e-15);
        // The flux of a constant field out of a closed surface is zero; of the position it is three volumes.
        let total: DVec3 = faces.iter().map(|face| face.normal() * face.area()).sum();
        assert!(total.length() < 1e-14);
        let volume: f64 = faces.iter().map(|face| face.center().dot(face.normal()) * face.area()).sum();
        assert_relative_eq!(volume / 3.0, 2.0 * 5.0 * 0.5, max_relative = 1e-14);
    }

    #[test]
    fn a_lens_is_as_thick_as_its_cap_is_high() {
        let lens = PlanoConvex::new(DVec3::ZERO, DVec3::Z, 2.0, 1.2).unwrap();
        assert_relative_eq!(lens.thickness(), 2.0 - 1.6, max_relative = 1e-15);
        assert!(matches!(
            PlanoConvex::new(DVec3::ZERO, DVec3::Z, 1.0, 1.2),
            Err(ShapeError::TooWide { field: "rim_radius", .. })
        ));
        assert!(PlanoConvex::new(DVec3::ZERO, DVec3::ZERO, 1.0, 0.5).is_err());
    }
}
