//! A case as a scene of Mitsuba 3: tried with 3.9.1, as `pip install mitsuba` brings it.
//!
//! What the scene says, and why:
//! - the camera is orthographic, looks at the receiver from between it and everything else, and so sees nothing but it; no
//!   flag is needed to hide sources. Its x axis points to the left;
//! - `disk` and `rectangle` emit to the side of their normal, the third axis of their matrix; meshes by winding, flat;
//! - `path` with `max_depth` 2 is direct light. Everything but the receiver is black, on both sides;
//! - the film keeps 32 bits (its default keeps 16) and a box filter of one pixel (its default, a Gaussian, mixes
//!   neighbours: correlation +0.34);
//! - a flat mirror is a `conductor` of no material, on both sides, with its reflectance at every angle; then `max_depth` is 3;
//! - a rectangle of fields is a `bitmap` without a filter between texels, whose v begins at the top of the picture;
//! - seeds are far apart: from neighbouring ones, pixels of the next image take up streams of the last.

use std::fmt::Write;

use glam::DVec3;

use super::{Inexpressible, Order, Recipe, SEEDS, camera, fields, grid, json, manifest, mirrors, triangles};
use crate::configuration::Configuration;
use crate::external::image::pfm;
use crate::external::{Manifest, PixelGrid};
use crate::geometry::{Frame, Rectangle, Shape};

/// Renders a number of independent images into one stack.
const RENDER: &str = include_str!("render.py");
/// The scene of a case, its manifest, and a script that renders it.
///
/// - error: everything that the scene cannot hold, by name
pub fn mitsuba(configuration: &Configuration, name: &str, order: &Order) -> Result<Recipe, Vec<Inexpressible>> {
    let (receiver, height) = camera(configuration)?;
    let pixels = grid(configuration, &receiver, order)?;
    let manifest = manifest(configuration, name, "mitsuba", pixels, order);
    let mut files = Vec::new();
    let mut scene = head(name, &receiver, height, &manifest);
    for (i, source) in configuration.sources().iter().enumerate() {
        let (id, radiance) = (format!("source-{i}"), manifest.radiance[i]);
        let radiance = match fields(source) {
            None => format!("<rgb name=\"radiance\" value=\"{radiance:?}\"/>"),
            Some(raster) => {
                let grid = raster.grid();
                // The file's rows go up, and the renderer's v begins at the top of a picture.
                let rows = raster.values().chunks(grid.ns()).rev().flatten();
                let values: Vec<f64> = rows.map(|m| m / std::f64::consts::PI).collect();
                files.push((format!("{id}.pfm"), pfm([grid.ns(), grid.nt()], &values)));
                format!(
                    "<texture type=\"bitmap\" name=\"radiance\"><string name=\"filename\" value=\"{id}.pfm\"/>\
                     <string name=\"filter_type\" value=\"nearest\"/><string name=\"wrap_mode\" value=\"clamp\"/>\
                     <boolean name=\"raw\" value=\"true\"/></texture>"
                )
            }
        };
        let emitter = format!("        <emitter type=\"area\">{radiance}</emitter>\n");
        shape(&mut scene, &mut files, source.shape(), &id, "black", &emitter);
    }
    for (i, occluder) in configuration.occluders().iter().enumerate() {
        shape(&mut scene, &mut files, occluder, &format!("occluder-{i}"), "black", "");
    }
    for (i, (outline, reflectance)) in mirrors(configuration).iter().enumerate() {
        let id = format!("mirror-{i}");
        let _ = writeln!(
            scene,
            "    <bsdf type=\"twosided\" id=\"{id}-sides\"><bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/>\
             <rgb name=\"specular_reflectance\" value=\"{reflectance:?}\"/></bsdf></bsdf>"
        );
        shape(&mut scene, &mut files, outline, &id, &format!("{id}-sides"), "");
    }
    scene += "</scene>\n";
    files.push(("scene.xml".to_owned(), scene.into_bytes()));
    files.push(("render.py".to_owned(), RENDER.as_bytes().to_vec()));
    files.push(("manifest.json".to_owned(), json(&manifest)));
    Ok(Recipe { files, manifest: Some(manifest) })
}

fn head(name: &str, receiver: &Rectangle, height: f64, manifest: &Manifest) -> String {
    let Manifest { pixels, rho, depth, .. } = manifest;
    let (u, v, normal) = (receiver.edge_u(), receiver.edge_v(), receiver.normal());
    // The film spans ±1 across and ±height/width upwards; scaled, it is the receiver.
    let upwards = v * (0.5 * pixels.width as f64 / pixels.height as f64);
    let eye = receiver.center() + normal * height;
    let camera = matrix([u * -0.5, upwards, -normal, eye]);
    let plane = matrix([u * 0.5, v * 0.5, normal, receiver.center()]);
    // A comment may hold no two dashes in a row.
    let name: String = name.chars().map(|c| if c.is_alphanumeric() || "/_.".contains(c) { c } else { ' ' }).collect();
    let PixelGrid { width, height: rows, .. } = pixels;
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>
<!-- {name}, written by etendue {version}. What the pixels are: manifest.json -->
<scene version=\"3.0.0\">
    <default name=\"spp\" value=\"{spp}\"/>
    <default name=\"sampler\" value=\"independent\"/>
    <default name=\"seed\" value=\"{seed}\"/>
    <integrator type=\"path\"><integer name=\"max_depth\" value=\"{depth}\"/></integrator>
    <bsdf type=\"twosided\" id=\"black\"><bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0\"/></bsdf></bsdf>
    <sensor type=\"orthographic\">
        <transform name=\"to_world\"><matrix value=\"{camera}\"/></transform>
        <float name=\"near_clip\" value=\"{near:?}\"/>
        <float name=\"far_clip\" value=\"{far:?}\"/>
        <sampler type=\"$sampler\">
            <integer name=\"sample_count\" value=\"$spp\"/>
            <integer name=\"seed\" value=\"$seed\"/>
        </sampler>
        <film type=\"hdrfilm\">
            <integer name=\"width\" value=\"{width}\"/>
            <integer name=\"height\" value=\"{rows}\"/>
            <string name=\"pixel_format\" value=\"rgb\"/>
            <string name=\"component_format\" value=\"float32\"/>
            <rfilter type=\"box\"/>
        </film>
    </sensor>
    <shape type=\"rectangle\" id=\"receiver\">
        <transform name=\"to_world\"><matrix value=\"{plane}\"/></transform>
        <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{rho:?}\"/></bsdf>
    </shape>
",
        version = env!("CARGO_PKG_VERSION"),
        spp = manifest.samples_per_pixel,
        seed = SEEDS.first,
        near = 1e-3 * height,
        far = 2.0 * height,
    )
}

/// The columns of an affine map, as Mitsuba reads it: row by row.
fn matrix([x, y, z, origin]: [DVec3; 4]) -> String {
    let row = |i: usize| format!("{:?} {:?} {:?} {:?}", x[i] + 0.0, y[i] + 0.0, z[i] + 0.0, origin[i] + 0.0);
    format!("{}  {}  {}  0 0 0 1", row(0), row(1), row(2))
}

fn shape(
    scene: &mut String,
    files: &mut Vec<(String, Vec<u8>)>,
    shape: &Shape,
    id: &str,
    material: &str,
    emitter: &str,
) {
    let (kind, place) = match shape {
        Shape::Disk(disk) => {
            let frame = Frame::around(disk.normal());
            let (x, y) = (frame.tangent * disk.radius(), frame.bitangent * disk.radius());
            ("disk", to_world([x, y, disk.normal(), disk.center()]))
        }
        Shape::Rectangle(s) => ("rectangle", to_world([s.edge_u() * 0.5, s.edge_v() * 0.5, s.normal(), s.center()])),
        Shape::Sphere(sphere) => {
            let c = sphere.center();
            let center = format!("<point name=\"center\" x=\"{:?}\" y=\"{:?}\" z=\"{:?}\"/>", c.x, c.y, c.z);
            ("sphere", format!("        {center}<float name=\"radius\" value=\"{:?}\"/>\n", sphere.radius()))
        }
        Shape::Polygon(polygon) => {
            files.push((format!("{id}.obj"), obj(polygon.vertices(), triangles(polygon))));
            ("obj", mesh_file(id))
        }
        Shape::Mesh(mesh) => {
            let triangles = mesh.triangles().iter().map(|corners| corners.map(|i| i as usize));
            files.push((format!("{id}.obj"), obj(mesh.vertices(), triangles)));
            ("obj", mesh_file(id))
        }
    };
    // Writing into a text cannot fail.
    let _ = write!(
        scene,
        "    <shape type=\"{kind}\" id=\"{id}\">\n{place}        <ref id=\"{material}\"/>\n{emitter}    </shape>\n"
    );
}

fn to_world(columns: [DVec3; 4]) -> String {
    format!("        <transform name=\"to_world\"><matrix value=\"{}\"/></transform>\n", matrix(columns))
}

fn mesh_file(id: &str) -> String {
    format!("        <string name=\"filename\" value=\"{id}.obj\"/><boolean name=\"face_normals\" value=\"true\"/>\n")
}

fn obj(vertices: &[DVec3], triangles: impl IntoIterator<Item = [usize; 3]>) -> Vec<u8> {
    let mut text = String::new();
    for v in vertices {
        let _ = writeln!(text, "v {:?} {:?} {:?}", v.x, v.y, v.z);
    }
    for [a, b, c] in triangles {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}
