//! One path, from the place that is measured to its end.

use super::next_event::straight;
use super::settings::PathSettings;
use super::skin::{Sends, Skin, Target};
use crate::configuration::Lamp;
use crate::geometry::DVec3;
use crate::light::{Draws, End, Ray, Room, Start, Tally, Tracer, cosine_direction};

/// A place of a surface, and the side of it that is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub at: DVec3,
    /// Unit vector.
    pub normal: DVec3,
    pub start: Start,
    pub medium: Option<usize>,
}

/// What one path found, W/m².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Found {
    pub direct: f64,
    pub caustic: f64,
    pub indirect: f64,
    /// Whether it came upon a source by chance: in any way, and in those of [`super::Part`].
    pub reached: [bool; 3],
    pub terminated: bool,
    /// Directions that it went, shadow rays not counted.
    pub segments: u64,
}

/// How a path's weight changes. As it stands it is right; tests put faults in its place.
pub(crate) trait Weighing: Sync {
    /// After a diffuse surface that sends on a share.
    fn sent_on(&self, weight: f64, share: f64) -> f64 {
        weight * share
    }
    /// After roulette that was survived with a chance.
    fn survived(&self, weight: f64, chance: f64) -> f64 {
        weight / chance
    }
    /// Whether a source counts that is met by chance.
    ///
    /// - `straight`: with no mirror or glass before it
    fn counts(&self, next_event: bool, straight: bool) -> bool {
        !(next_event && straight)
    }
}

/// The right one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AsItIs;

impl Weighing for AsItIs {}

/// What all paths of a run share.
pub(super) struct Walker<'a, W: Weighing> {
    pub room: &'a Room,
    pub skins: &'a [Skin],
    pub targets: &'a [Target],
    pub lamps: &'a [Lamp],
    pub settings: PathSettings,
    pub weighing: &'a W,
}

/// Where a path goes on from a surface, and with which share.
enum Next {
    Nowhere,
    From { normal: DVec3, share: f64 },
}

impl<W: Weighing> Walker<'_, W> {
    /// - `tally`: scratch, whose books are never read; `branches`: scratch, stays empty
    #[inline(always)]
    pub fn walk(
        &self,
        from: Place,
        tracer: &Tracer,
        branches: &mut Vec<Ray>,
        tally: &mut Tally,
        draws: &mut Draws,
    ) -> Found {
        let mut found = Found::default();
        let (mut place, mut weight, mut reflections) = (from, 1.0, 0);
        loop {
            if self.settings.next_event {
                let asked = straight(&place, self.room, self.skins, self.targets, self.lamps, draws);
                found.add(weight * asked, reflections, 0);
            }
            found.segments += 1;
            let direction = cosine_direction(place.normal, draws);
            let mut ray = Ray::new(place.at, direction, place.start, place.medium, 1.0);
            let end = loop {
                match tracer.advance(&mut ray, f64::INFINITY, branches, draws, tally) {
                    Ok(true) => {}
                    Ok(false) => return found,
                    Err(end) => break end,
                }
            };
            let (surface, at) = match end {
                End::Surface { surface, at } => (surface, at),
                End::Terminated => return Found { terminated: true, ..found },
                End::Escaped | End::Mesh => return found,
            };
            weight *= ray.flux();
            let skin = &self.skins[surface];
            let outward = self.room.normal(surface, at);
            let on_front = ray.direction.dot(outward) < 0.0;
            let glow = skin.glow.at(at, on_front);
            if glow > 0.0 {
                found.reached[0] = true;
                found.reached[1] |= reflections == 0 && ray.order > 0;
                found.reached[2] |= reflections > 0;
                if self.weighing.counts(self.settings.next_event, ray.order == 0) {
                    found.add(weight * glow, reflections, ray.order);
                }
            }
            let Next::From { normal, share } = next(skin, at, outward, on_front, draws) else { return found };
            reflections += 1;
            if reflections > self.settings.depth {
                return Found { terminated: true, ..found };
            }
            weight = self.weighing.sent_on(weight, share);
            if reflections > self.settings.roulette_after {
                if draws.unit() >= share {
                    return found;
                }
                weight = self.weighing.survived(weight, share);
            }
            place = Place { at, normal, start: Start::Face(surface), medium: ray.medium };
        }
    }
}

/// What a surface does with a path that has met it.
#[inline(always)]
fn next(skin: &Skin, at: DVec3, outward: DVec3, on_front: bool, draws: &mut Draws) -> Next {
    let (normal, share) = match &skin.sends {
        Sends::Nothing => return Next::Nowhere,
        Sends::Back { inward, .. } if *inward == on_front => return Next::Nowhere,
        Sends::Back { albedo, inward } => (if *inward { -outward } else { outward }, *albedo),
        Sends::Read(_) if !on_front => return Next::Nowhere,
        Sends::Read(receiver) => (outward, receiver.albedo_at(at).map_or(0.0, |albedo| albedo.ratio())),
        Sends::Shade { transmittance, .. } if on_front => (-outward, *transmittance),
        Sends::Shade { albedo, transmittance } => {
            // Back inside or through, in proportion to both.
            let share = albedo + transmittance;
            (if draws.unit() * share < *albedo { -outward } else { outward }, share)
        }
    };
    if share > 0.0 { Next::From { normal, share } } else { Next::Nowhere }
}

impl Found {
    #[inline(always)]
    fn add(&mut self, light: f64, reflections: usize, order: usize) {
        match (reflections, order) {
            (0, 0) => self.direct += light,
            (0, _) => self.caustic += light,
            _ => self.indirect += light,
        }
    }
    /// In the order of [`super::Part::ALL`].
    #[inline(always)]
    pub fn parts(&self) -> [f64; 3] {
        [self.direct + self.caustic + self.indirect, self.caustic, self.indirect]
    }
}
