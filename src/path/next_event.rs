//! Next-event estimation: light that comes straight from the sources, asked for by shadow rays.

use std::f64::consts::PI;

use super::skin::{Skin, Target};
use super::walk::Place;
use crate::configuration::Lamp;
use crate::geometry::DVec3;
use crate::light::{Draws, Met, Room};

/// What a place gets straight from all sources, W/m²: of each surface one point is asked, uniform by area, and what it would
/// bring stands for all of it, M A cosθ cosθ′/(π r²); lamps are asked as they are.
#[inline(always)]
pub(super) fn straight(
    place: &Place,
    room: &Room,
    skins: &[Skin],
    targets: &[Target],
    lamps: &[Lamp],
    draws: &mut Draws,
) -> f64 {
    let mut found = 0.0;
    for target in targets {
        let offset = draws.on(&target.surface);
        found += from_surface(place, room, skins, target, offset);
    }
    for lamp in lamps {
        found += from_lamp(place, room, lamp);
    }
    found
}

#[inline(always)]
fn from_surface(place: &Place, room: &Room, skins: &[Skin], target: &Target, offset: DVec3) -> f64 {
    let at = target.surface.origin() + offset;
    let normal = target.surface.flat_normal().unwrap_or_else(|| offset.normalize()) * target.side;
    let towards = at - place.at;
    let squared = towards.length_squared();
    let direction = towards / squared.sqrt();
    let (arrives, leaves) = (direction.dot(place.normal), -direction.dot(normal));
    // Not so for a point that is the place itself either: then they are no numbers.
    if !(arrives > 0.0 && leaves > 0.0) {
        return 0.0;
    }
    let (_, met) = room.nearest(place.at, direction, place.start, place.medium);
    if met != Met::Face(target.index) {
        return 0.0;
    }
    let exitance = skins[target.index].glow.at(at, target.side > 0.0);
    exitance * target.area * arrives * leaves / (PI * squared)
}

#[inline(always)]
fn from_lamp(place: &Place, room: &Room, lamp: &Lamp) -> f64 {
    let (direction, distance, irradiance) = match lamp {
        Lamp::Point(lamp) => {
            let towards = lamp.position() - place.at;
            let squared = towards.length_squared();
            let distance = squared.sqrt();
            (towards / distance, distance, lamp.intensity().watts_per_steradian() / squared)
        }
        Lamp::Beam(lamp) => {
            let offset = place.at - lamp.center();
            let along = offset.dot(lamp.direction());
            let across = offset - lamp.direction() * along;
            if along <= 0.0 || across.length() > lamp.radius() {
                return 0.0;
            }
            (-lamp.direction(), along, lamp.irradiance().watts_per_square_metre())
        }
    };
    let arrives = direction.dot(place.normal);
    if arrives <= 0.0 || irradiance == 0.0 {
        return 0.0;
    }
    let (free, _) = room.nearest(place.at, direction, place.start, place.medium);
    if free < distance { 0.0 } else { irradiance * arrives }
}
