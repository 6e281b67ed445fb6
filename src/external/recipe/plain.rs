//! A case in numbers, as JSON: for a script that makes a renderer's scene of it, in whatever words that renderer has.

use serde::Serialize;

use super::{
    Inexpressible, Order, Recipe, beam_and_ball, beyond_direct_light, camera_height, fields, grid, json, manifest,
    mirrors, receiver, reflectance, triangles,
};
use crate::configuration::Configuration;
use crate::external::Manifest;
use crate::geometry::{DVec3, Shape};
use crate::texture::Raster;

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
    /// Reflect on both sides. Light takes one of them at most: the manifest's `depth` is then 3.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    mirrors: Vec<Mirror>,
    /// Parallel light, evenly over a disk. With a beam and a ball of glass there is nothing else, the manifest's `depth` is 4, and
    /// light that passed straight through the ball is all that is due.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    beams: Vec<ParallelBeam>,
    /// In air; clear.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    glass: Vec<Ball>,
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
    /// W/m², on the side of the normal; of a source with fields, the mean.
    exitance: f64,
    /// W/(m² sr)
    radiance: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    fields: Option<Fields>,
}

/// A rectangle that does not shine evenly: equal fields, each even in itself.
#[derive(Serialize)]
struct Fields {
    /// Along `edge_u`.
    columns: usize,
    /// Along `edge_v`.
    rows: usize,
    /// `[row][column]`, from the corner centre − edge_u/2 − edge_v/2, W/(m² sr).
    radiance: Vec<f64>,
}

#[derive(Serialize)]
struct ParallelBeam {
    center: [f64; 3],
    direction: [f64; 3],
    radius: f64,
    /// W/m², across it.
    irradiance: f64,
}

#[derive(Serialize)]
struct Ball {
    #[serde(flatten)]
    body: Body,
    /// Refractive index.
    index: f64,
}

#[derive(Serialize)]
struct Mirror {
    #[serde(flatten)]
    body: Body,
    /// The share of the light that goes on, at any angle.
    reflectance: f64,
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
/// - error: everything that is more than direct light and light by one flat mirror, by name
pub fn plain(configuration: &Configuration, name: &str, order: &Order) -> Result<Recipe, Vec<Inexpressible>> {
    let caustic = beam_and_ball(configuration);
    let beyond = if caustic.is_some() { vec![] } else { beyond_direct_light(configuration) };
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
        let fields = fields(source).map(|raster| Fields {
            columns: raster.grid().ns(),
            rows: raster.grid().nt(),
            radiance: radiances(raster),
        });
        Emitter { body: body(source.shape()), exitance, radiance: exitance / std::f64::consts::PI, fields }
    });
    let scene = Scene {
        schema_version: Manifest::SCHEMA_VERSION,
        generator: format!("etendue {}", env!("CARGO_PKG_VERSION")),
        case: name.to_owned(),
        digest: configuration.digest().to_string(),
        units: Manifest::UNITS,
        sources: sources.collect(),
        occluders: configuration.occluders().iter().map(body).collect(),
        mirrors: mirrors(configuration)
            .iter()
            .map(|(shape, reflectance)| Mirror { body: body(shape), reflectance: *reflectance })
            .collect(),
        beams: caustic
            .iter()
            .map(|(beam, ..)| ParallelBeam {
                center: beam.center().to_array(),
                direction: beam.direction().to_array(),
                radius: beam.radius(),
                irradiance: beam.irradiance().watts_per_square_metre(),
            })
            .collect(),
        glass: caustic
            .iter()
            .map(|(_, ball, index)| Ball { body: body(&Shape::Sphere(**ball)), index: *index })
            .collect(),
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

/// L = M/π of every texel.
fn radiances(raster: &Raster) -> Vec<f64> {
    raster.values().iter().map(|exitance| exitance / std::f64::consts::PI).collect()
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
