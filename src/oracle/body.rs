//! Surfaces prepared once per configuration: what they are made of, before anyone looks.

use glam::DVec3;

use super::outline;
use super::surface::Surface;
use crate::geometry::{Shape, Sphere};

/// A surface that emits or blocks.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub figure: Figure,
    /// A ball around it; its centre lies in the plane of a flat figure.
    pub center: DVec3,
    pub reach: f64,
}

#[derive(Clone, Debug)]
pub(super) enum Figure {
    Disk {
        normal: DVec3,
        /// The same direction to the digits it was given with, of any length.
        as_given: DVec3,
        radius: f64,
    },
    Ball {
        radius: f64,
    },
    Flat(Flat),
    /// A mesh that is not flat: an occluder only.
    Mesh(Box<Surface>),
}

/// A flat figure with straight edges: one outline or several, with holes or without.
#[derive(Clone, Debug)]
pub(super) struct Flat {
    /// Unit; the edges run counter-clockwise about it.
    pub normal: DVec3,
    /// The corners are `origin + offset`: a rectangle's offsets keep digits that its corners' coordinates have lost.
    pub origin: DVec3,
    pub offsets: Vec<DVec3>,
    /// Indices into `offsets`.
    pub edges: Vec<[u32; 2]>,
    pub convex: bool,
}

impl Body {
    /// The bodies that a shape is made of: one, but for a flat mesh whose faces overlap.
    ///
    /// - `scale`: a power of two that all lengths are multiplied by
    pub fn of_shape(shape: &Shape, scale: f64) -> Vec<Body> {
        match shape {
            Shape::Disk(s) => {
                let figure =
                    Figure::Disk { normal: s.normal(), as_given: s.normal_as_given(), radius: s.radius() * scale };
                vec![Body { figure, center: s.center() * scale, reach: s.radius() * scale }]
            }
            Shape::Sphere(s) => vec![Body::of_ball(s, scale)],
            Shape::Rectangle(s) => {
                let (u, v) = (s.edge_u() * (0.5 * scale), s.edge_v() * (0.5 * scale));
                let offsets = vec![-u - v, u - v, u + v, v - u];
                vec![Body::of_flat(Flat {
                    normal: s.normal(),
                    origin: s.center() * scale,
                    edges: outline::loop_of(offsets.len()),
                    offsets,
                    convex: true,
                })]
            }
            Shape::Polygon(s) => {
                let offsets: Vec<_> = s.vertices().iter().map(|v| *v * scale).collect();
                vec![Body::of_flat(Flat {
                    normal: s.normal(),
                    origin: DVec3::ZERO,
                    edges: outline::loop_of(offsets.len()),
                    offsets,
                    convex: s.is_convex(),
                })]
            }
            Shape::Mesh(s) => {
                let patches: Vec<Body> = outline::flat_patches(s, scale).into_iter().map(Body::of_flat).collect();
                if patches.len() <= 1 { patches } else { vec![Body::of_surface(Surface::new(s, scale, patches))] }
            }
        }
    }

    fn of_ball(sphere: &Sphere, scale: f64) -> Body {
        let radius = sphere.radius() * scale;
        Body { figure: Figure::Ball { radius }, center: sphere.center() * scale, reach: radius }
    }

    fn of_surface(surface: Surface) -> Body {
        let points = &surface.points;
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let center = low + (high - low) * 0.5;
        let reach = points.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
        Body { figure: Figure::Mesh(Box::new(surface)), center, reach }
    }

    pub(super) fn of_flat(flat: Flat) -> Body {
        // The mean of the corners lies in their plane; relative to one of them, so that far corners keep their digits.
        let first = flat.offsets[0];
        let middle = first + flat.offsets.iter().map(|p| *p - first).sum::<DVec3>() / flat.offsets.len() as f64;
        let reach = flat.offsets.iter().map(|p| (*p - middle).length()).fold(0.0, f64::max);
        Body { center: flat.origin + middle, reach, figure: Figure::Flat(flat) }
    }
}
