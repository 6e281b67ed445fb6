//! Whether an occluder lies wholly inside a source, as a point sees them: then a closed ring of the source is left.

use glam::DVec3;

use crate::configuration::{Configuration, MeasurementPoint};
use crate::geometry::{Disk, Shape, Sphere};

/// True where this can be told; never for more than one source or occluder.
///
/// Told: corners before a disk, a sphere or a convex outline; disks and spheres before a convex outline; parallel disks; two
/// spheres. The source must be wholly above the point's horizon, or what is left is no ring.
pub(super) fn is_seen(configuration: &Configuration, point: &MeasurementPoint) -> bool {
    let ([source], [occluder]) = (configuration.sources(), configuration.occluders()) else { return false };
    let eye = point.position();
    let Some(inside) = Inside::of(source.shape(), eye, point.normal()) else { return false };
    match occluder {
        Shape::Disk(disk) => inside.disk(disk.center() - eye, disk),
        Shape::Sphere(sphere) => inside.sphere(sphere.center() - eye, sphere),
        Shape::Rectangle(rectangle) => rectangle.corners().iter().all(|corner| inside.point(*corner - eye)),
        Shape::Polygon(polygon) => polygon.vertices().iter().all(|corner| inside.point(*corner - eye)),
        Shape::Mesh(mesh) => mesh.vertices().iter().all(|corner| inside.point(*corner - eye)),
    }
}

/// The inside of a source: the directions that it fills, as far as it. All relative to the eye.
enum Inside {
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
    /// `cosine` of the half-angle; `height` of the silhouette's plane.
    Sphere {
        axis: DVec3,
        distance: f64,
        radius: f64,
        cosine: f64,
        height: f64,
    },
    /// Inward normals of the planes through the eye and an edge; the source's own normal, and the eye's height over it.
    Outline {
        planes: Vec<DVec3>,
        normal: DVec3,
        height: f64,
    },
}

impl Inside {
    /// `None` for a source that is cut by the horizon, turned away, or no convex outline.
    fn of(shape: &Shape, eye: DVec3, n: DVec3) -> Option<Inside> {
        let outline = |corners: &[DVec3], normal: DVec3| {
            let corners: Vec<DVec3> = corners.iter().map(|corner| *corner - eye).collect();
            let height = -normal.dot(corners[0]);
            let next = |i: usize| corners[(i + 1) % corners.len()];
            // Counter-clockwise from the lit side, on which the eye is.
            let planes = (0..corners.len()).map(|i| corners[i].cross(next(i)).normalize_or_zero() * -1.0).collect();
            let seen = height > 0.0 && corners.iter().all(|corner| n.dot(*corner) >= 0.0);
            seen.then_some(Inside::Outline { planes, normal, height })
        };
        match shape {
            Shape::Disk(disk) => {
                let (center, normal) = (disk.center() - eye, disk.normal());
                let lowest = n.dot(center) - disk.radius() * n.cross(normal).length();
                (normal.dot(center) < 0.0 && lowest >= 0.0).then_some(Inside::Disk {
                    center,
                    normal,
                    radius: disk.radius(),
                })
            }
            Shape::Sphere(sphere) => {
                let center = sphere.center() - eye;
                let (distance, radius) = (center.length(), sphere.radius());
                if distance <= radius || n.dot(center) < radius {
                    return None;
                }
                let power = (distance - radius) * (distance + radius);
                let (cosine, height) = (power.sqrt() / distance, power / distance);
                Some(Inside::Sphere { axis: center / distance, distance, radius, cosine, height })
            }
            Shape::Rectangle(rectangle) => outline(&rectangle.corners(), rectangle.normal()),
            Shape::Polygon(polygon) if polygon.is_convex() => outline(polygon.vertices(), polygon.normal()),
            _ => None,
        }
    }

    /// Whether a point lies before the source.
    fn point(&self, at: DVec3) -> bool {
        match self {
            Inside::Disk { center, normal, radius } => {
                // Drawn out to the source's plane.
                let farther = center.dot(*normal) / at.dot(*normal);
                farther > 1.0 && (at * farther).distance(*center) < *radius
            }
            Inside::Sphere { axis, cosine, height, .. } => {
                let along = at.dot(*axis);
                along > 0.0 && along < *height && along > cosine * at.length()
            }
            Inside::Outline { planes, normal, height } => {
                normal.dot(at) > -height && normal.dot(at) < 0.0 && planes.iter().all(|plane| plane.dot(at) > 0.0)
            }
        }
    }

    fn disk(&self, center: DVec3, disk: &Disk) -> bool {
        let reach = |plane: DVec3| disk.radius() * plane.cross(disk.normal()).length();
        match self {
            Inside::Disk { center: own, normal, radius } => {
                // Parallel disks only: the shadow on the source's plane is a circle.
                let farther = own.dot(*normal) / center.dot(*normal);
                let is_parallel = normal.cross(disk.normal()).length() <= 4.0 * f64::EPSILON;
                is_parallel && farther > 1.0 && (center * farther).distance(*own) + disk.radius() * farther < *radius
            }
            Inside::Sphere { .. } => false,
            Inside::Outline { planes, normal, height } => {
                let along = normal.dot(center);
                along - reach(*normal) > -height
                    && along + reach(*normal) < 0.0
                    && planes.iter().all(|plane| plane.dot(center) > reach(*plane))
            }
        }
    }

    fn sphere(&self, center: DVec3, sphere: &Sphere) -> bool {
        match self {
            Inside::Disk { .. } => false,
            Inside::Sphere { axis, distance, radius, .. } => {
                let away = center.length();
                let is_nearer = away < *distance && (*axis * *distance).distance(center) > radius + sphere.radius();
                let apart = axis.cross(center).length().atan2(axis.dot(center));
                let half = |radius: f64, distance: f64| (radius / distance).min(1.0).asin();
                away > sphere.radius() && is_nearer && apart + half(sphere.radius(), away) < half(*radius, *distance)
            }
            Inside::Outline { planes, normal, height } => {
                let along = normal.dot(center);
                along - sphere.radius() > -height
                    && along + sphere.radius() < 0.0
                    && planes.iter().all(|plane| plane.dot(center) > sphere.radius())
            }
        }
    }
}
