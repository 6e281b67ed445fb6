//! What a receiver gets in all, by light of whatever number of interactions, in rooms where that is known.

use super::layout::{self, Screen};
use super::meridian::{Body, Field, Passage};
use super::{Bounded, CausticLayout, power_by_flat_mirror};
use crate::configuration::{Configuration, GlassShape, Lamp, ReceiverShape};
use crate::oracle::Oracle;
use crate::oracle::patch::{Tolerance, average_irradiance};

/// Flux that is deposited on the receiver, W; `None` where it is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepositedPower {
    /// By light of all orders.
    pub all: Option<Bounded>,
    /// By way of one flat mirror, of all that there is: [`power_by_flat_mirror`].
    pub by_flat_mirror: Option<Bounded>,
}

/// All flux that is deposited on the receiver.
///
/// - area sources and one flat mirror: direct light, by the mean irradiance, and the light that was mirrored
/// - a beam into a paraboloid or spherical mirror, if all of it lands at once
/// - a point source over a slab: all echoes, each by its tube of rays
/// - a beam through a ball or a plano-convex lens: all orders, by quadrature over the beam
///
/// - `depth`: interactions after which light is given up
/// - error: `bound`, an estimate: of quadrature
pub fn deposited_power(room: &Configuration, depth: usize) -> DepositedPower {
    let by_flat_mirror = power_by_flat_mirror(room);
    let all = match by_flat_mirror {
        Some(mirrored) if depth >= 1 => with_direct(room, mirrored),
        _ => by_lamps(room, depth),
    };
    DepositedPower { all, by_flat_mirror }
}

/// With the light that comes straight.
fn with_direct(room: &Configuration, mirrored: Bounded) -> Option<Bounded> {
    let patch = layout::patch(room)?;
    let direct = average_irradiance(&Oracle::new(room), &patch, Tolerance::relative(1e-9));
    let [value, bound] = [direct.irradiance, direct.bound].map(|x| x.watts_per_square_metre() * patch.area());
    Some(Bounded { value: mirrored.value + value, bound: mirrored.bound + bound })
}

fn by_lamps(room: &Configuration, depth: usize) -> Option<Bounded> {
    if !room.diffuse().is_empty() {
        return None;
    }
    let known = CausticLayout::of(room)?;
    match (room.lamps(), room.glass()) {
        ([Lamp::Beam(beam)], [glass]) => {
            let receiver = Screen::of(room.receiver()?.shape())?;
            let body = match glass.shape() {
                GlassShape::Sphere(ball) => Body::Ball { radius: ball.radius() },
                GlassShape::PlanoConvex(lens) => {
                    Body::Lens { radius: lens.curvature_radius(), thickness: lens.thickness() }
                }
                GlassShape::Slab(_) => return None,
            };
            let origin = match glass.shape() {
                GlassShape::PlanoConvex(lens) => lens.vertex(),
                other => other.bounding_sphere().0,
            };
            let field = match room.receiver()?.shape() {
                ReceiverShape::Rectangle(s) => {
                    Field::Rectangle([0.5 * s.edge_u().length(), 0.5 * s.edge_v().length()])
                }
                ReceiverShape::Disk(s) => Field::Disk(s.radius()),
                _ => return None,
            };
            let is_centered = (known.foot() - receiver.center()).length() <= 1e-12 * receiver.height(origin);
            let passage = Passage {
                body,
                index: glass.ior(),
                beam_radius: beam.radius(),
                height: -receiver.height(origin),
                field,
            };
            is_centered.then(|| passage.power(depth).scaled(beam.irradiance().watts_per_square_metre()))
        }
        ([Lamp::Beam(_)], []) if depth >= 1 => {
            // What misses the receiver might meet the mirror again.
            let [all, here] = [known.power_on_plane(1)?, known.power_on_receiver(1)?];
            ((all.value - here.value).abs() <= 1e-9 * all.value).then_some(here)
        }
        ([Lamp::Point(lamp)], [glass]) => {
            let GlassShape::Slab(slab) = glass.shape() else { return None };
            // Light that has been to the slab's sides comes back only after more interactions than are followed: a step from
            // face to face is no longer than that of the critical angle.
            let half = 0.5 * slab.middle().edge_u().length().min(slab.middle().edge_v().length());
            let step = slab.thickness() / (glass.ior() * glass.ior() - 1.0).sqrt();
            let off = (slab.middle().center() - known.foot()).length() + known.room();
            let never_back = (half - off) / step >= depth as f64;
            let ReceiverShape::Disk(disk) = room.receiver()?.shape() else { return None };
            let is_centered = (known.foot() - disk.center()).length() <= 1e-12 * disk.radius();
            if !(never_back && is_centered && depth >= 2) {
                return None;
            }
            known.through_slab(glass, lamp.position(), (depth as u32 - 2) / 2, disk.radius())
        }
        _ => None,
    }
}
