//! Curved shapes that mirrors have: caps of spheres, cylinders, paraboloids. None is closed.

use std::f64::consts::PI;

use glam::DVec3;

use super::shape::{ShapeError, Sphere, finite, positive, unit};

/// The part of a sphere around an axis, up to a rim: at most half of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereCap {
    sphere: Sphere,
    axis: DVec3,
    rim_radius: f64,
}

impl SphereCap {
    /// - `sphere`: what it is cut from; `axis`: from the sphere's centre to the middle of the cap, any length but zero
    /// - `rim_radius`: metres, > 0, at most the sphere's radius
    pub fn new(sphere: Sphere, axis: DVec3, rim_radius: f64) -> Result<SphereCap, ShapeError> {
        let cap = SphereCap { sphere, axis: unit("axis", axis)?, rim_radius: positive("rim_radius", rim_radius)? };
        if rim_radius > sphere.radius() {
            return Err(ShapeError::TooWide { field: "rim_radius", said: rim_radius, most: sphere.radius() });
        }
        Ok(cap)
    }
    /// The whole sphere.
    pub fn sphere(&self) -> Sphere {
        self.sphere
    }
    /// Unit vector from the sphere's centre to the middle of the cap.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }
    /// Metres.
    pub fn rim_radius(&self) -> f64 {
        self.rim_radius
    }
    /// Distance of the rim's plane from the sphere's centre, √(R² − a²), metres.
    pub fn rim_height(&self) -> f64 {
        let radius = self.sphere.radius();
        ((radius - self.rim_radius) * (radius + self.rim_radius)).sqrt()
    }
    /// 2 π R (R − √(R² − a²)), square metres.
    pub fn area(&self) -> f64 {
        let (radius, rim) = (self.sphere.radius(), self.rim_radius);
        // R − √(R² − a²) = a²/(R + √(R² − a²))
        2.0 * PI * radius * (rim * rim / (radius + self.rim_height()))
    }
    /// A sphere that holds the cap: about the rim's centre, as wide as the rim.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        (self.sphere.center() + self.axis * self.rim_height(), self.rim_radius)
    }
}

/// The wall of a circular cylinder, or a part of its round; without lids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    center: DVec3,
    axis: DVec3,
    radius: f64,
    height: f64,
    toward: DVec3,
    arc: f64,
}

impl Cylinder {
    /// The whole wall.
    ///
    /// - `center`: of the axis, at half height, metres; `axis`: any length but zero; `radius`, `height`: metres, > 0
    pub fn new(center: DVec3, axis: DVec3, radius: f64, height: f64) -> Result<Cylinder, ShapeError> {
        let axis = unit("axis", axis)?;
        Ok(Cylinder {
            center: finite("center", center)?,
            axis,
            radius: positive("radius", radius)?,
            height: positive("height", height)?,
            toward: axis.any_orthonormal_vector(),
            arc: 1.0,
        })
    }
    /// A part of the round.
    ///
    /// - `toward`: from the axis to the middle of the part, any direction but along the axis
    /// - `arc`: share of the full circle, in (0, 1]
    pub fn part(self, toward: DVec3, arc: f64) -> Result<Cylinder, ShapeError> {
        let toward = unit("toward", toward)?;
        let across = toward - self.axis * toward.dot(self.axis);
        if across.length() < 1e-9 {
            return Err(ShapeError::AlongAxis { field: "toward" });
        }
        if !(arc > 0.0 && arc <= 1.0) {
            return Err(ShapeError::NotAShare { field: "arc", said: arc });
        }
        Ok(Cylinder { toward: across.normalize(), arc, ..self })
    }
    /// Metres.
    pub fn center(&self) -> DVec3 {
        self.center
    }
    /// Unit vector.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }
    /// Metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }
    /// Metres.
    pub fn height(&self) -> f64 {
        self.height
    }
    /// Unit vector across the axis, to the middle of the part that there is.
    pub fn toward(&self) -> DVec3 {
        self.toward
    }
    /// Share of the full circle, in (0, 1].
    pub fn arc(&self) -> f64 {
        self.arc
    }
    /// Square metres.
    pub fn area(&self) -> f64 {
        2.0 * PI * self.radius * self.arc * self.height
    }
    /// A sphere that holds the wall.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        (self.center, self.radius.hypot(0.5 * self.height))
    }
}

/// A paraboloid of revolution, z = r²/4f up to a rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paraboloid {
    vertex: DVec3,
    axis: DVec3,
    focal_length: f64,
    rim_radius: f64,
}

impl Paraboloid {
    /// - `vertex`: metres; `axis`: from the vertex to the focus, any length but zero
    /// - `focal_length`, `rim_radius`: metres, > 0
    pub fn new(vertex: DVec3, axis: DVec3, focal_length: f64, rim_radius: f64) -> Result<Paraboloid, ShapeError> {
        Ok(Paraboloid {
            vertex: finite("vertex", vertex)?,
            axis: unit("axis", axis)?,
            focal_length: positive("focal_length", focal_length)?,
            rim_radius: positive("rim_radius", rim_radius)?,
        })
    }
    /// Metres.
    pub fn vertex(&self) -> DVec3 {
        self.vertex
    }
    /// Unit vector towards the focus.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }
    /// Metres.
    pub fn focal_length(&self) -> f64 {
        self.focal_length
    }
    /// Metres.
    pub fn rim_radius(&self) -> f64 {
        self.rim_radius
    }
    /// Height of the rim over the vertex, a²/4f, metres.
    pub fn depth(&self) -> f64 {
        self.rim_radius * self.rim_radius / (4.0 * self.focal_length)
    }
    /// (8 π f²/3) ((1 + a²/4f²)^{3/2} − 1), square metres.
    pub fn area(&self) -> f64 {
        let f = self.focal_length;
        // With u = a²/4f²: (1 + u)^{3/2} − 1 = u (u² + 3u + 3)/((1 + u)^{3/2} + 1), without cancellation.
        let u = (0.5 * self.rim_radius / f) * (0.5 * self.rim_radius / f);
        let root = (1.0 + u).sqrt();
        8.0 * PI / 3.0 * f * f * u * (u * u + 3.0 * u + 3.0) / ((1.0 + u) * root + 1.0)
    }
    /// A sphere that holds the paraboloid: through vertex and rim, or about the rim's middle where that is wider.
    pub fn bounding_sphere(&self) -> (DVec3, f64) {
        let (depth, rim) = (self.depth(), self.rim_radius);
        // From height h on the axis the squared distance, 4 f z + (z − h)², is largest at an end: the vertex or the rim.
        let height = if depth > rim { 0.5 * (depth + rim * (rim / depth)) } else { depth };
        (self.vertex + self.axis * height, rim.hypot(depth - height).max(height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn areas_agree_with_rings() {
        let cap = SphereCap::new(Sphere::new(DVec3::ZERO, 2.0).unwrap(), DVec3::Z, 1.5).unwrap();
        let dish = Paraboloid::new(DVec3::ZERO, DVec3::Z, 0.7, 1.5).unwrap();
        let rings = 20_000;
        let sum = |slope: &dyn Fn(f64) -> f64| -> f64 {
            (0..rings)
                .map(|k| {
                    let r = 1.5 * (f64::from(k) + 0.5) / f64::from(rings);
                    2.0 * PI * r * 1.5 / f64::from(rings) * slope(r).hypot(1.0)
                })
                .sum()
        };
        assert_relative_eq!(cap.area(), sum(&|r| r / (4.0 - r * r).sqrt()), max_relative = 1e-7);
        assert_relative_eq!(dish.area(), sum(&|r| r / 1.4), max_relative = 1e-7);
        let half = Cylinder::new(DVec3::ZERO, DVec3::Z, 2.0, 3.0).unwrap().part(DVec3::X, 0.5).unwrap();
        assert_relative_eq!(half.area(), 6.0 * PI, max_relative = 1e-15);
    }

    #[test]
    fn bounds_hold_their_shape() {
        for (focal_length, rim) in [(1.0, 0.1), (1.0, 1.0), (0.1, 1.0), (0.01, 1.0), (0.25, 1.0), (0.3, 1.2)] {
            let dish = Paraboloid::new(DVec3::ONE, DVec3::X, focal_length, rim).unwrap();
            let (center, reach) = dish.bounding_sphere();
            for k in 0..=1000 {
                let r = rim * f64::from(k) / 1000.0;
                let at = DVec3::ONE + DVec3::X * (r * r / (4.0 * focal_length)) + DVec3::Y * r;
                assert!((at - center).length() <= reach * (1.0 + 1e-15), "{focal_length} {rim} {r}");
            }
        }
    }

    #[test]
    fn what_is_no_shape_is_refused_by_the_name_of_its_field() {
        let ball = Sphere::new(DVec3::ZERO, 1.0).unwrap();
        assert!(matches!(SphereCap::new(ball, DVec3::Z, 1.5), Err(ShapeError::TooWide { field: "rim_radius", .. })));
        assert!(SphereCap::new(ball, DVec3::ZERO, 0.5).is_err() && SphereCap::new(ball, DVec3::Z, 0.0).is_err());
        let wall = Cylinder::new(DVec3::ZERO, DVec3::Z, 1.0, 1.0).unwrap();
        assert!(matches!(wall.part(DVec3::Z, 0.5), Err(ShapeError::AlongAxis { field: "toward" })));
        for arc in [0.0, -0.1, 1.1, f64::NAN] {
            assert!(matches!(wall.part(DVec3::X, arc), Err(ShapeError::NotAShare { field: "arc", .. })));
        }
        assert!(Cylinder::new(DVec3::ZERO, DVec3::Z, 1.0, f64::NAN).is_err());
        assert!(Paraboloid::new(DVec3::ZERO, DVec3::Z, -1.0, 1.0).is_err());
    }
}
