//! Reading the camera.

use glam::DVec3;

use super::error::CaseError;
use super::schema::{self, Key};
use super::walk::{Log, Node};
#[cfg(feature = "studies")]
use crate::configuration::Configuration;
use crate::eye::{Camera, EyeError, Projection};

const KINDS: [&str; 2] = ["orthographic", "perspective"];
const PIXELS: [usize; 2] = [640, 480];

/// The camera, unless something is wrong with it.
pub(super) fn camera(node: &Node, log: &mut Log) -> Option<Camera> {
    let before = log.len();
    let kind = node.text(&schema::KIND, log).and(node.raw(&schema::KIND));
    let kind = kind.and_then(|value| node.name_among(&schema::KIND, value, &KINDS, log));
    let eye = node.vector(&schema::EYE, log);
    let look_at = node.vector(&schema::LOOK_AT, log);
    let up = if node.has(&schema::UP) { node.direction(&schema::UP, log) } else { Some(DVec3::Z) };
    let pixels = if node.has(&schema::PIXELS) { pixels(node, log) } else { Some(PIXELS) };
    let projection = match kind {
        Some("orthographic") => {
            foreign(node, &schema::FOV, KINDS[1], "orthographic camera", log);
            size(node, &schema::WIDTH, log).map(|width| Projection::Orthographic { width })
        }
        Some(_) => {
            foreign(node, &schema::WIDTH, KINDS[0], "perspective camera", log);
            size(node, &schema::FOV, log).map(|fov| Projection::Perspective { fov })
        }
        None => None,
    };
    match Camera::new(projection?, eye?, look_at?, up?, pixels?) {
        Ok(camera) => (log.len() == before).then_some(camera),
        Err(error) => {
            log.add(node.span_of(error.field()), CaseError::Camera(EyeError::Camera(error)));
            None
        }
    }
}

/// Notes a camera that stands inside of something. Who takes no pictures does not ask.
#[cfg(feature = "studies")]
pub(super) fn place(node: &Node, camera: &Camera, room: &Configuration, log: &mut Log) {
    if let Err(error) = crate::eye::View::Camera(*camera).stands_free(room) {
        log.add(node.span_of(schema::EYE.name), CaseError::Camera(error));
    }
}

/// A number that this kind of camera cannot do without.
fn size(node: &Node, key: &Key, log: &mut Log) -> Option<f64> {
    if !node.has(key) && !node.misspells(key) {
        let expected = format!("a number ({})", key.unit);
        log.add(node.span.clone(), CaseError::MissingKey { table: node.schema.title(), key: key.name, expected });
    }
    if node.has(key) { node.number(key, log) } else { None }
}

fn foreign(node: &Node, key: &Key, accepted: &'static str, shape: &'static str, log: &mut Log) {
    if node.has(key) {
        let key_name = node.schema.full_name(key.name);
        let accepted = if accepted == KINDS[0] { "an orthographic camera" } else { "a perspective camera" };
        log.add(node.span_of(key.name), CaseError::ForeignKey { key: key_name, accepted, shape });
    }
}

fn pixels(node: &Node, log: &mut Log) -> Option<[usize; 2]> {
    let value = node.raw(&schema::PIXELS)?;
    let items = node.items(&schema::PIXELS, value, log)?;
    let most = Camera::MOST_SIDE as u64;
    let sides: Vec<_> = items.iter().map(|item| node.count_of(&schema::PIXELS, item, 1, most, log)).collect();
    let [width, height] = sides[..] else {
        let key = node.schema.full_name(schema::PIXELS.name);
        log.add(value.span(), CaseError::Length { key, what: "numbers", said: sides.len(), expected: 2 });
        return None;
    };
    Some([usize::try_from(width?).ok()?, usize::try_from(height?).ok()?])
}
