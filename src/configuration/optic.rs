//! What bends light on its way: mirrors and glass.

use glam::DVec3;

use super::ConfigurationError;
use crate::geometry::{Cylinder, Disk, Paraboloid, PlanoConvex, Polygon, Rectangle, Shape, Slab, Sphere, SphereCap};

/// A mirror's shape. Both sides reflect.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MirrorShape {
    Rectangle(Rectangle),
    Polygon(Polygon),
    Disk(Disk),
    Sphere(Sphere),
    SphereCap(SphereCap),
    Cylinder(Cylinder),
    Paraboloid(Paraboloid),
}

impl MirrorShape {
    /// The name a case file uses.
    pub fn kind(&self) -> &'static str {
        match self {
            MirrorShape::Rectangle(_) => "rectangle",
            MirrorShape::Polygon(_) => "polygon",
            MirrorShape::Disk(_) => "disk",
            MirrorShape::Sphere(_) | MirrorShape::SphereCap(_) => "sphere",
            MirrorShape::Cylinder(_) => "cylinder",
            MirrorShape::Paraboloid(_) => "paraboloid",
        }
    }
    /// Square metres.
    pub fn area(&self) -> f64 {
        match self {
            MirrorShape::Rectangle(s) => s.area(),
            MirrorShape::Polygon(s) => s.area(),
            MirrorShape::Disk(s) => s.area(),
            MirrorShape::Sphere(s) => s.area(),
            MirrorShape::SphereCap(s) => s.area(),
            MirrorShape::Cylinder(s) => s.area(),
            MirrorShape::Paraboloid(s) => s.area(),
        }
    }
    /// Centre and radius of a sphere that holds the shape, metres.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        match self {
            MirrorShape::Rectangle(s) => around(&s.corners()),
            MirrorShape::Polygon(s) => around(s.vertices()),
            MirrorShape::Disk(s) => (s.center(), s.radius()),
            MirrorShape::Sphere(s) => (s.center(), s.radius()),
            MirrorShape::SphereCap(s) => s.bounding_sphere(),
            MirrorShape::Cylinder(s) => s.bounding_sphere(),
            MirrorShape::Paraboloid(s) => s.bounding_sphere(),
        }
    }
    /// What blocks the same light, where that is known in closed form: flat shapes and whole spheres.
    pub fn outline(&self) -> Option<Vec<Shape>> {
        let shape = match self {
            MirrorShape::Rectangle(s) => Shape::Rectangle(*s),
            MirrorShape::Polygon(s) => Shape::Polygon(s.clone()),
            MirrorShape::Disk(s) => Shape::Disk(*s),
            MirrorShape::Sphere(s) => Shape::Sphere(*s),
            MirrorShape::SphereCap(_) | MirrorShape::Cylinder(_) | MirrorShape::Paraboloid(_) => return None,
        };
        Some(vec![shape])
    }
}

/// A sphere that holds some points, about the middle of their box.
fn around(points: &[DVec3]) -> (DVec3, f64) {
    let low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let middle = low * 0.5 + high * 0.5;
    (middle, points.iter().map(|p| (*p - middle).length()).fold(0.0, f64::max))
}

/// A perfectly smooth mirror.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    shape: MirrorShape,
    reflectance: f64,
}

impl Mirror {
    /// - `reflectance`: the share of arriving power that goes on, at any angle and polarisation; in [0, 1], the rest is
    ///   absorbed
    pub fn new(shape: MirrorShape, reflectance: f64) -> Result<Mirror, ConfigurationError> {
        if !(0.0..=1.0).contains(&reflectance) {
            return Err(ConfigurationError::Reflectance { said: reflectance });
        }
        Ok(Mirror { shape, reflectance })
    }
    pub fn shape(&self) -> &MirrorShape {
        &self.shape
    }
    /// In [0, 1].
    pub fn reflectance(&self) -> f64 {
        self.reflectance
    }
}

/// The shape of a piece of glass: closed and convex.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum GlassShape {
    Sphere(Sphere),
    Slab(Slab),
    PlanoConvex(PlanoConvex),
}

impl GlassShape {
    /// The name a case file uses.
    pub fn kind(&self) -> &'static str {
        match self {
            GlassShape::Sphere(_) => "sphere",
            GlassShape::Slab(_) => "slab",
            GlassShape::PlanoConvex(_) => "plano_convex",
        }
    }
    /// Square metres.
    pub fn area(&self) -> f64 {
        match self {
            GlassShape::Sphere(s) => s.area(),
            GlassShape::Slab(s) => s.area(),
            GlassShape::PlanoConvex(s) => s.area(),
        }
    }
    /// Centre and radius of a sphere that holds the shape, metres.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        match self {
            GlassShape::Sphere(s) => (s.center(), s.radius()),
            GlassShape::Slab(s) => s.bounding_sphere(),
            GlassShape::PlanoConvex(s) => s.bounding_sphere(),
        }
    }
    /// What blocks the same light, where that is known in closed form: all but the lens.
    pub fn outline(&self) -> Option<Vec<Shape>> {
        match self {
            GlassShape::Sphere(s) => Some(vec![Shape::Sphere(*s)]),
            GlassShape::Slab(s) => Some(s.faces().into_iter().map(Shape::Rectangle).collect()),
            GlassShape::PlanoConvex(_) => None,
        }
    }
    /// The point of the body that is nearest to another point, metres.
    fn nearest(&self, to: DVec3) -> DVec3 {
        let in_ball = |center: DVec3, radius: f64, p: DVec3| {
            let offset = p - center;
            let length = offset.length();
            if length > radius { center + offset * (radius / length) } else { p }
        };
        match self {
            GlassShape::Sphere(s) => in_ball(s.center(), s.radius(), to),
            GlassShape::Slab(s) => {
                let middle = s.middle();
                let offset = to - middle.center();
                let (u, v) = (middle.edge_u(), middle.edge_v());
                let along = |edge: DVec3| edge * (offset.dot(edge) / edge.length_squared()).clamp(-0.5, 0.5);
                let half = 0.5 * s.thickness();
                let height = offset.dot(middle.normal()).clamp(-half, half);
                middle.center() + along(u) + along(v) + middle.normal() * height
            }
            GlassShape::PlanoConvex(s) => {
                let flat = s.vertex() + s.axis() * s.thickness();
                let above = (to - flat).dot(s.axis());
                let on_ball = in_ball(s.curvature_center(), s.curvature_radius(), to);
                if (on_ball - flat).dot(s.axis()) <= 0.0 {
                    return on_ball;
                }
                // Beyond the flat face: the nearest point of its disk.
                in_ball(flat, s.rim_radius(), to - s.axis() * above)
            }
        }
    }
    /// Whether two bodies share more than the points where they touch: alternating projections between two convex sets
    /// tend to a pair of nearest points.
    ///
    /// - error: bodies that touch, or come nearer to each other than 1e-6 of their size, may count as apart or as not
    pub(super) fn overlaps(&self, other: &GlassShape) -> bool {
        let (mut from, reach) = self.bounding_sphere();
        let (center, other_reach) = other.bounding_sphere();
        if (from - center).length() >= reach + other_reach {
            return false;
        }
        for _ in 0..10_000 {
            let there = other.nearest(from);
            let back = self.nearest(there);
            if (back - there).length() <= 1e-12 * (reach + other_reach) {
                return true;
            }
            let step = (back - from).length();
            from = back;
            if step <= 1e-15 * (reach + other_reach) {
                break;
            }
        }
        false
    }
}

/// A piece of clear glass: nothing is absorbed in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    shape: GlassShape,
    ior: f64,
}

impl Glass {
    /// - `ior`: index of refraction relative to the surroundings, finite, ≥ 1
    pub fn new(shape: GlassShape, ior: f64) -> Result<Glass, ConfigurationError> {
        if !(ior.is_finite() && ior >= 1.0) {
            return Err(ConfigurationError::Ior { said: ior });
        }
        Ok(Glass { shape, ior })
    }
    pub fn shape(&self) -> &GlassShape {
        &self.shape
    }
    /// Relative to the surroundings.
    pub fn ior(&self) -> f64 {
        self.ior
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_materials_are_refused() {
        let ball = Sphere::new(DVec3::ZERO, 1.0).unwrap();
        for said in [-0.1, 1.1, f64::NAN] {
            let found = Mirror::new(MirrorShape::Sphere(ball), said);
            assert!(matches!(found, Err(ConfigurationError::Reflectance { .. })));
        }
        for said in [0.9, 0.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Glass::new(GlassShape::Sphere(ball), said), Err(ConfigurationError::Ior { .. })));
        }
        assert!(Glass::new(GlassShape::Sphere(ball), 1.0).is_ok());
    }

    #[test]
    fn bodies_that_cut_into_each_other_are_found() {
        let ball = |z: f64| GlassShape::Sphere(Sphere::new(DVec3::Z * z, 1.0).unwrap());
        let plate = Rectangle::new(DVec3::Z * -1.2, DVec3::X * 4.0, DVec3::Y * 4.0).unwrap();
        let slab = |thickness: f64| GlassShape::Slab(Slab::new(plate, thickness).unwrap());
        let lens = |z: f64| GlassShape::PlanoConvex(PlanoConvex::new(DVec3::Z * z, -DVec3::Z, 2.0, 1.0).unwrap());
        assert!(ball(0.0).overlaps(&ball(1.9)) && !ball(0.0).overlaps(&ball(2.1)));
        assert!(ball(0.0).overlaps(&ball(0.1)) && ball(0.0).overlaps(&ball(0.0)));
        assert!(ball(0.0).overlaps(&slab(0.5)) && !ball(0.0).overlaps(&slab(0.3)));
        assert!(slab(0.5).overlaps(&ball(0.0)) && !slab(0.3).overlaps(&ball(0.0)));
        // The lens's curved side is up, its flat side 0.27 m below.
        assert!(lens(-0.9).overlaps(&ball(0.0)) && !lens(-1.01).overlaps(&ball(0.0)));
        assert!(lens(1.2).overlaps(&ball(0.0)) && !lens(1.3).overlaps(&ball(0.0)));
    }
}
