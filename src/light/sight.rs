//! What a ray from an eye comes to, by the same surfaces and faces that rays from the light meet.
//!
//! Radiance is kept along a ray in air, so an eye ray is followed backwards through mirrors and glass until it ends at
//! something that shines or scatters. At glass both branches are followed, each with its share (unpolarised at every face).

use std::f64::consts::PI;

use super::interface::{Interface, reflected};
use super::room::{Met, Role, Room, Start};
use crate::configuration::{Configuration, GlassShape, Lamp, MirrorShape, ReceiverShape};
use crate::geometry::{DVec3, Shape};

/// Most mirrors and faces of glass on one path of an eye.
const MOST_FACES: usize = 24;
/// A branch with less than this share of its pixel is followed no further.
const FAINT: f64 = 1e-4;

/// What an eye ray ends at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// It leaves the room.
    Nothing,
    /// The lit side of one of [`crate::configuration::Contents::sources`].
    Source(usize),
    /// What sends nothing: an occluder, the dark side of a source or of a diffuse surface.
    Black,
    /// The front of the surface of a map: the receiver's, if there is one, then those of the diffuse surfaces.
    Surface(usize),
    /// It was given up, after many faces or for its faintness.
    Lost,
}

/// What a ray meets first of all, whatever lies behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum First {
    Nothing,
    Source,
    Black,
    Surface,
    Mirror,
    Glass,
}

/// One end of an eye ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    pub seen: Seen,
    /// Metres; of no meaning where nothing is seen.
    pub at: DVec3,
    /// Of the surface on its front, unit; nought where there is none.
    pub normal: DVec3,
    /// Share of what leaves there that reaches the eye, in [0, 1].
    pub share: f64,
    /// Whether no mirror and no glass is on the way.
    pub is_straight: bool,
}

#[derive(Clone, Copy)]
struct Branch {
    from: DVec3,
    direction: DVec3,
    start: Start,
    medium: Option<usize>,
    share: f64,
    faces: usize,
}

/// A solid ball, by its role and index.
struct Ball {
    role: &'static str,
    index: usize,
    center: DVec3,
    radius: f64,
}

/// A configuration, prepared for rays from an eye.
pub struct Sight {
    room: Room,
    n_sources: usize,
    lamps: Vec<Lamp>,
    /// The surface of each map, and whether its inside is its front.
    of_map: Vec<(usize, bool)>,
    balls: Vec<Ball>,
}

impl Sight {
    /// Prepares all surfaces.
    pub fn new(configuration: &Configuration) -> Sight {
        let room = Room::new(configuration);
        let mut of_map = vec![(0, false); room.n_maps()];
        for surface in 0..room.n_surfaces() {
            if let Role::Receives { map, inward } = room.role(surface) {
                of_map[map] = (surface, inward);
            }
        }
        let contents = configuration.contents();
        let n_sources = contents.sources.len();
        Sight { room, n_sources, lamps: contents.lamps.clone(), of_map, balls: balls(configuration) }
    }

    /// Surfaces that scatter: the receiver, if there is one, then the diffuse surfaces.
    pub fn n_surfaces(&self) -> usize {
        self.of_map.len()
    }

    /// The role and index of a solid body that holds a point, if one does.
    pub fn inside(&self, point: DVec3) -> Option<(&'static str, usize)> {
        let holds = |ball: &&Ball| (point - ball.center).length() < ball.radius;
        let ball = self.balls.iter().find(holds).map(|ball| (ball.role, ball.index));
        ball.or_else(|| self.room.medium_at(point).map(|glass| ("glass", glass)))
    }

    /// Follows a ray to all of its ends, whose shares sum to 1 at most.
    ///
    /// - `from`: outside of all bodies, metres; `direction`: unit vector; `ends`: emptied first
    /// - returns what is met first
    pub fn follow(&self, from: DVec3, direction: DVec3, ends: &mut Vec<Sighting>) -> First {
        ends.clear();
        let mut first = None;
        let mut left = vec![Branch { from, direction, start: Start::Nowhere, medium: None, share: 1.0, faces: 0 }];
        while let Some(branch) = left.pop() {
            let (distance, met) = self.room.nearest(branch.from, branch.direction, branch.start, branch.medium);
            let at = branch.from + branch.direction * distance;
            let mut end = |seen: Seen, normal: DVec3| {
                ends.push(Sighting { seen, at, normal, share: branch.share, is_straight: branch.faces == 0 });
            };
            let is_last = branch.faces >= MOST_FACES;
            let on = |start: Start, direction: DVec3, share: f64, medium: Option<usize>| Branch {
                from: at,
                direction,
                start,
                medium,
                share: branch.share * share,
                faces: branch.faces + 1,
            };
            let seen = match met {
                Met::Nothing => {
                    end(Seen::Nothing, DVec3::ZERO);
                    First::Nothing
                }
                Met::Mesh => {
                    end(Seen::Black, DVec3::ZERO);
                    First::Black
                }
                Met::Face(surface) => {
                    let normal = self.room.normal(surface, at);
                    let faces_eye = branch.direction.dot(normal) < 0.0;
                    let towards_eye = if faces_eye { normal } else { -normal };
                    match self.room.role(surface) {
                        Role::Absorbs if surface < self.n_sources && faces_eye => {
                            end(Seen::Source(surface), normal);
                            First::Source
                        }
                        Role::Receives { map, inward } if faces_eye != inward => {
                            end(Seen::Surface(map), towards_eye);
                            First::Surface
                        }
                        Role::Absorbs | Role::Receives { .. } => {
                            end(Seen::Black, towards_eye);
                            First::Black
                        }
                        Role::Reflects { .. } if is_last => {
                            end(Seen::Lost, towards_eye);
                            First::Mirror
                        }
                        Role::Reflects { reflectance, .. } => {
                            let back = reflected(branch.direction, normal);
                            left.push(on(Start::Face(surface), back, reflectance, branch.medium));
                            First::Mirror
                        }
                    }
                }
                Met::Glass(glass, part) => {
                    let outward = self.room.glass_normal(glass, part, at);
                    let ior = self.room.ior(glass);
                    let (normal, from, into, behind) = match branch.medium {
                        Some(_) => (-outward, ior, 1.0, None),
                        None => (outward, 1.0, ior, Some(glass)),
                    };
                    let face = Interface::meet(branch.direction, normal, from, into);
                    let turned_back = 0.5 * (face.reflectance_s + face.reflectance_p);
                    let back = (turned_back, Some(reflected(branch.direction, normal)), branch.medium);
                    let through = (1.0 - turned_back, face.refracted, behind);
                    for (share, direction, medium) in [back, through] {
                        let Some(direction) = direction.filter(|_| share > 0.0) else { continue };
                        let next = on(Start::Glass(glass, part), direction, share, medium);
                        if is_last || next.share < FAINT {
                            let share = next.share;
                            ends.push(Sighting { seen: Seen::Lost, at, normal, share, is_straight: false });
                        } else {
                            left.push(next);
                        }
                    }
                    First::Glass
                }
            };
            first.get_or_insert(seen);
        }
        first.unwrap_or(First::Nothing)
    }

    /// What lamps bring straight to a point of a surface, W/m²: all or nothing of each, so that shadows are sharp. Mirrors
    /// and glass stand in the way.
    ///
    /// - `map`: whose surface the point lies on; `normal`: unit, on its front
    pub fn from_lamps(&self, map: usize, at: DVec3, normal: DVec3) -> f64 {
        let start = Start::Face(self.of_map[map].0);
        let reaches = |towards: DVec3, distance: f64| {
            let (stop, met) = self.room.nearest(at, towards, start, None);
            // A mesh is told where the search for it ended, not where it stands.
            stop >= distance && (met != Met::Mesh || !self.room.mesh_before(at, towards, distance))
        };
        let mut irradiance = 0.0;
        for lamp in &self.lamps {
            match lamp {
                Lamp::Point(lamp) => {
                    let way = lamp.position() - at;
                    let distance = way.length();
                    let towards = way / distance;
                    let cosine = towards.dot(normal);
                    if distance > 0.0 && cosine > 0.0 && reaches(towards, distance) {
                        irradiance += lamp.power().watts() / (4.0 * PI) * cosine / (distance * distance);
                    }
                }
                Lamp::Beam(beam) => {
                    let towards = -beam.direction();
                    let way = beam.center() - at;
                    let distance = way.dot(towards);
                    let aside = (way - towards * distance).length();
                    let cosine = towards.dot(normal);
                    let is_in = distance > 0.0 && aside < beam.radius();
                    if is_in && cosine > 0.0 && reaches(towards, distance) {
                        irradiance += beam.irradiance().watts_per_square_metre() * cosine;
                    }
                }
            }
        }
        irradiance
    }
}

/// Every ball that an eye cannot be in.
fn balls(configuration: &Configuration) -> Vec<Ball> {
    let contents = configuration.contents();
    let mut balls = Vec::new();
    let mut add = |role: &'static str, index: usize, center: DVec3, radius: f64| {
        balls.push(Ball { role, index, center, radius });
    };
    let sources = contents.sources.iter().map(|source| source.shape());
    for (role, index, shape) in sources
        .enumerate()
        .map(|(k, shape)| ("source", k, shape))
        .chain(contents.occluders.iter().enumerate().map(|(k, shape)| ("occluder", k, shape)))
    {
        if let Shape::Sphere(s) = shape {
            add(role, index, s.center(), s.radius());
        }
    }
    for (index, mirror) in contents.mirrors.iter().enumerate() {
        if let MirrorShape::Sphere(s) = mirror.shape() {
            add("mirror", index, s.center(), s.radius());
        }
    }
    for (index, glass) in contents.glass.iter().enumerate() {
        if let GlassShape::Sphere(s) = glass.shape() {
            add("glass", index, s.center(), s.radius());
        }
    }
    if let Some(ReceiverShape::Sphere(s)) = contents.receiver.as_ref().map(|receiver| receiver.shape()) {
        add("receiver", 0, s.center(), s.radius());
    }
    for (index, surface) in contents.diffuse.iter().enumerate().filter(|(_, surface)| !surface.is_inward()) {
        if let ReceiverShape::Sphere(s) = surface.shape() {
            add("diffuse", index, s.center(), s.radius());
        }
    }
    balls
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Contents, Glass, Mirror, Receiver, Source};
    use crate::geometry::{Disk, Mesh, Rectangle, Sphere};
    use crate::light::{Light, LightSettings, trace};
    use crate::radiometry::{Albedo, Exitance, Flux, PointSource};

    fn floor() -> Receiver {
        let floor = Rectangle::new(DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0).unwrap();
        Receiver::new(ReceiverShape::Rectangle(floor), Some(Albedo::new(0.5))).unwrap()
    }

    fn room(contents: Contents) -> Configuration {
        let source =
            Source::new(Shape::Disk(Disk::new(DVec3::Z * 3.0, -DVec3::Z, 0.5).unwrap()), Exitance::new(1.0)).unwrap();
        let sources = if contents.lamps.is_empty() { vec![source] } else { vec![] };
        Configuration::of(Contents { sources, receiver: Some(floor()), diffuse: vec![], ..contents }).unwrap()
    }

    fn plate() -> Mirror {
        let plate = Rectangle::new(DVec3::Z * 2.0, DVec3::X, DVec3::Y).unwrap();
        Mirror::new(MirrorShape::Rectangle(plate), 0.8).unwrap()
    }

    #[test]
    fn a_ray_ends_where_light_would_come_from() {
        let mirrored = room(Contents { mirrors: vec![plate()], ..Contents::default() });
        let sight = Sight::new(&mirrored);
        let mut ends = Vec::new();
        // Up from the floor into the mirror and down again.
        assert_eq!(sight.follow(DVec3::new(0.1, 0.0, 1.0), DVec3::Z, &mut ends), First::Mirror);
        assert_eq!(ends.len(), 1);
        assert_eq!((ends[0].seen, ends[0].share, ends[0].is_straight), (Seen::Surface(0), 0.8, false));
        assert!(ends[0].at.z.abs() < 1e-15);
        // From above the source's dark side; from beside it, its lit side.
        assert_eq!(sight.follow(DVec3::Z * 9.0, -DVec3::Z, &mut ends), First::Black);
        let from = DVec3::new(1.5, 0.0, 1.0);
        let up = (DVec3::new(0.3, 0.0, 3.0) - from).normalize();
        assert_eq!(sight.follow(from, up, &mut ends), First::Source);
        assert_eq!(ends[0].seen, Seen::Source(0));
        // The floor's back lets the ray pass.
        assert_eq!(sight.follow(DVec3::new(1.9, 1.9, -1.0), DVec3::Z, &mut ends), First::Nothing);
    }

    #[test]
    fn shares_of_all_branches_sum_to_one() {
        let ball = Sphere::new(DVec3::Z, 0.5).unwrap();
        let glass = vec![Glass::new(GlassShape::Sphere(ball), 1.5).unwrap()];
        let sight = Sight::new(&room(Contents { glass, ..Contents::default() }));
        let mut ends = Vec::new();
        for k in 0..50 {
            let from = DVec3::new(0.02 * f64::from(k) - 0.45, 0.1, 2.5);
            assert_eq!(
                sight.follow(from, -DVec3::Z, &mut ends),
                if from.length() > 0.0 && (from.x.hypot(0.1)) < 0.5 { First::Glass } else { First::Surface }
            );
            let sum: f64 = ends.iter().map(|end| end.share).sum();
            assert!((sum - 1.0).abs() < 1e-14, "{from}: {sum}");
            let lost: f64 = ends.iter().filter(|end| end.seen == Seen::Lost).map(|end| end.share).sum();
            assert!(lost < 1e-3, "{from}: {lost} lost");
        }
        assert_eq!(sight.inside(DVec3::Z * 0.7), Some(("glass", 0)));
        assert_eq!(sight.inside(DVec3::Z * 0.4), None);
    }

    #[test]
    fn lamps_bring_what_rays_from_them_bring() {
        let lamp = Lamp::Point(PointSource::new(DVec3::new(0.3, 0.2, 3.0), Flux::new(50.0)).unwrap());
        let corner = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let veil =
            Mesh::new(vec![corner(-2.0, -2.0), corner(-0.5, -2.0), corner(-2.0, 2.0)], vec![[0, 1, 2]]).unwrap();
        let lit = room(Contents {
            lamps: vec![lamp],
            mirrors: vec![plate()],
            occluders: vec![Shape::Mesh(veil)],
            ..Contents::default()
        });
        let sight = Sight::new(&lit);
        let settings = LightSettings { rays: 400_000, map: [8, 8], ..LightSettings::default() };
        let map = trace(&lit, &settings, crate::statistics::budget::seed_of("lamps_bring")).maps.remove(0);
        for texel in map.grid().texels() {
            // The middle rule on a fine grid: off by the light's curvature, and where a shadow's edge crosses.
            let [[s0, s1], [t0, t1]] = map.grid().extent(texel);
            let fine = 32;
            let mut mean = 0.0;
            for i in 0..fine * fine {
                let share = |k: usize| (k as f64 + 0.5) / fine as f64;
                let at = map
                    .parametrisation()
                    .to_surface([s0 + (s1 - s0) * share(i % fine), t0 + (t1 - t0) * share(i / fine)]);
                mean += sight.from_lamps(0, at, DVec3::Z) / (fine * fine) as f64;
            }
            let found = map.irradiance(texel, Light::Direct).unwrap().watts_per_square_metre();
            let sd = map.moments(texel, Light::Direct).std_error(map.n_groups()).unwrap() / map.area(texel);
            assert!((found - mean).abs() <= 6.0 * sd + 0.02 * mean.max(0.01), "{texel:?}: {found} ± {sd}, {mean}");
        }
    }
}
