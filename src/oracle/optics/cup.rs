//! The room of the cup: one slanting beam, half of a cylinder mirror, its floor.

use super::{Bounded, CylinderMirror};
use crate::configuration::{Configuration, Lamp, MirrorShape, ReceiverShape};
use crate::geometry::{DVec3, Rectangle};

/// What light of one reflection brings to the tiles of a cup's floor.
#[derive(Clone, Debug)]
pub struct CupLayout {
    mirror: CylinderMirror,
    floor: Rectangle,
    /// On the axis, in the floor.
    foot: DVec3,
    /// Level, towards the middle of the wall, and to the left of it.
    axes: [DVec3; 2],
    /// Of the direct light on the floor, times what the mirror sends back, W/m².
    scale: f64,
    radius: f64,
}

/// Directions are the same, and lengths, to this many parts in one.
const ALIGNED: f64 = 1e-12;

impl CupLayout {
    /// `None` for any other room: one beam that slants towards the middle of the inside of a half cylinder mirror, wide
    /// enough for all of it, and a rectangle as floor, square to the cylinder's axis, on which the wall stands.
    pub fn of(room: &Configuration) -> Option<CupLayout> {
        let ([], [], []) = (room.sources(), room.occluders(), room.diffuse()) else { return None };
        let ([Lamp::Beam(beam)], [mirror], []) = (room.lamps(), room.mirrors(), room.glass()) else { return None };
        let MirrorShape::Cylinder(wall) = mirror.shape() else { return None };
        let ReceiverShape::Rectangle(floor) = room.receiver()?.shape() else { return None };
        let up = floor.normal();
        let (radius, height) = (wall.radius(), wall.height());
        let foot = wall.center() - wall.axis() * (0.5 * height) * wall.axis().dot(up).signum();
        let down = -beam.direction().dot(up);
        let level = beam.direction() + up * down;
        let forward = wall.toward();
        // The wall's upper edge and its ends, as the beam sees them.
        let across = up.cross(forward) * radius;
        let ends = [across, -across, across + forward * radius, forward * radius - across];
        let corners = ends.into_iter().flat_map(|end| [foot + end, foot + end + up * height]);
        let is_within = |place: DVec3| {
            let way = place - beam.center();
            way.dot(beam.direction()) > 0.0 && way.cross(beam.direction()).length() <= beam.radius()
        };
        let fits = (wall.arc() - 0.5).abs() <= ALIGNED
            && wall.axis().cross(up).length() <= ALIGNED
            && (foot - floor.center()).dot(up).abs() <= ALIGNED * radius
            && down > 0.0
            && level.length() > ALIGNED
            && level.normalize().distance(forward) <= ALIGNED
            && corners.clone().all(is_within);
        if !fits {
            return None;
        }
        Some(CupLayout {
            mirror: CylinderMirror::new(radius, height * level.length() / down).ok()?,
            floor: *floor,
            foot,
            axes: [forward, up.cross(forward)],
            scale: beam.irradiance().watts_per_square_metre() * down * mirror.reflectance(),
            radius,
        })
    }

    /// The order that is known: one reflection.
    pub const ORDER: usize = 1;

    /// Power in a part of the floor, W, by its extent along the floor's edges; `None` where it reaches out of the circle of the
    /// wall (there the wall's other side, and light that leaves the cup, would count), or its edges lie askew to the beam.
    ///
    /// - `s`, `t`: shares of the edges `edge_u` and `edge_v`, ascending
    pub fn power_in_part(&self, s: [f64; 2], t: [f64; 2]) -> Option<Bounded> {
        let (u, v) = (self.floor.edge_u(), self.floor.edge_v());
        let corners = [[s[0], t[0]], [s[1], t[0]], [s[1], t[1]], [s[0], t[1]]].map(|[s, t]| {
            let from = self.floor.center() + u * (s - 0.5) + v * (t - 0.5) - self.foot;
            self.axes.map(|axis| from.dot(axis))
        });
        let extent = |axis: usize| {
            let of = corners.map(|corner| corner[axis]);
            [of.iter().copied().fold(f64::INFINITY, f64::min), of.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
        };
        let is_inside = corners.iter().all(|[x, y]| x.hypot(*y) <= self.radius);
        let is_level = u.dot(self.axes[0]).abs().min(u.dot(self.axes[1]).abs()) <= ALIGNED * u.length();
        if !(is_inside && is_level) {
            return None;
        }
        Some(self.mirror.power_in_rectangle(extent(0), extent(1)).ok()?.scaled(self.scale))
    }
}
