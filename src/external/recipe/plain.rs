//! A case in numbers, as JSON: for a script that makes a renderer's scene of it, in whatever words that renderer has.

use serde::Serialize;

use super::{
    Inexpressible, Order, Recipe, beyond_direct_light, camera_height, grid, json, manifest, receiver, reflectance,
    triangles,
};
use crate::configuration::Configuration;
use crate::external::Manifest;
use crate::geometry::{DVec3, Shape};

/// What `scene.json` holds. Metres; right-handed.
#[derive(Serialize)]
struct Scene {
    schema_version: u32,
    generator: String,
    case: String,
    digest: String,
    units: &'static str,
    sources: Vec<Emitter>,
    /// Black, on both sides.
    occluders: Vec<Body>,
    /// `null` where it is no rectangle.
    receiver: Option<Receiver>,
    /// Over the middle of the receiver; an orthographic camera there sees nothing else. `null` where there is no room.
    camera_height: Option<f64>,
    points: Vec<Point>,
}

#[derive(Serialize)]
struct Emitter {
    #[serde(flatten)]
    body: Body,
    /// W/m², on the side of the normal.
    exitance: f64,
    /// W/(m² sr)
    radiance: f64,
}

#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
enum Body {
    Disk {
        center: [f64; 3],
        normal: [f64; 3],
        radius: f64,
    },
    Rectangle {
        center: [f64; 3],
        edge_u: [f64; 3],
        edge_v: [f64; 3],
        normal: [f64; 3],
    },
    Sphere {
        center: [f64; 3],
        radius: f64,
    },
    /// Counter-clockwise as seen from the side of the normal.
    Polygon {
        vertices: Vec<[f64; 3]>,
        normal: [f64; 3],
        triangles: Vec<[usize; 3]>,
    },
    Mesh {
        vertices: Vec<[f64; 3]>,
        triangles: Vec<[usize; 3]>,
    },
}

#[derive(Serialize)]
struct Receiver {
    center: [f64; 3],
    edge_u: [f64; 3],
    edge_v: [f64; 3],
    normal: [f64; 3],
    rho: f64,
}

#[derive(Serialize)]
struct Point {
    position: [f64; 3],
    normal: [f64; 3],
}

/// The case in numbers; and the manifest of images of it, where the receiver is a rectangle.
///
/// - error: everything that is more than direct light, by name
pub fn plain(configuration: &Configuration, name: &str, order: &Order) -> Result<Recipe, Vec<Inexpressible>> {
    let beyond = beyond_direct_light(configuration);
    if !beyond.is_empty() {
        return Err(beyond);
    }
    let rectangle = receiver(configuration).ok();
    let manifest = match &rectangle {
        Some(rectangle) => {
            let pixels = grid(configuration, rectangle, order)?;
            Some(manifest(configuration, name, "external", pixels, order))
        }
        None => None,
    };
    let sources = configuration.sources().iter().map(|source| {
        let exitance = source.exitance().watts_per_square_metre();
        Emitter { body: body(source.shape()), exitance, radiance: exitance / std::f64::consts::PI }
    });
    let scene = Scene {
        schema_version: Manifest::SCHEMA_VERSION,
        generator: format!("etendue {}", env!("CARGO_PKG_VERSION")),
        case: name.to_owned(),
        digest: configuration.digest().to_string(),
        units: Manifest::UNITS,
        sources: sources.collect(),
        occluders: configuration.occluders().iter().map(body).collect(),
        receiver: rectangle.map(|r| Receiver {
            center: r.center().to_array(),
            edge_u: r.edge_u().to_array(),
            edge_v: r.edge_v().to_array(),
            normal: r.normal().to_array(),
            rho: reflectance(configuration),
        }),
        camera_height: rectangle.and_then(|receiver| camera_height(configuration, &receiver).ok()),
        points: configuration
            .points()
            .iter()
            .map(|point| Point { position: point.position().to_array(), normal: point.normal().to_array() })
            .collect(),
    };
    let mut files = vec![("scene.json".to_owned(), json(&scene))];
    files.extend(manifest.as_ref().map(|manifest| ("manifest.json".to_owned(), json(manifest))));
    Ok(Recipe { files, manifest })
}

fn body(shape: &Shape) -> Body {
    let triples = |points: &[DVec3]| points.iter().map(|p| p.to_array()).collect();
    match shape {
        Shape::Disk(s) => {
            Body::Disk { center: s.center().to_array(), normal: s.normal().to_array(), radius: s.radius() }
        }
        Shape::Rectangle(s) => Body::Rectangle {
            center: s.center().to_array(),
            edge_u: s.edge_u().to_array(),
            edge_v: s.edge_v().to_array(),
            normal: s.normal().to_array(),
        },
        Shape::Sphere(s) => Body::Sphere { center: s.center().to_array(), radius: s.radius() },
        Shape::Polygon(s) => {
            Body::Polygon { vertices: triples(s.vertices()), normal: s.normal().to_array(), triangles: triangles(s) }
        }
        Shape::Mesh(s) => Body::Mesh {
            vertices: triples(s.vertices()),
            triangles: s.triangles().iter().map(|corners| corners.map(|i| i as usize)).collect(),
        },
    }
}
