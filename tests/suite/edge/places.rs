//! Far from the origin, and far from the light: coordinates that are exact there move a value by no more than its bound.

use etendue::configuration::{Arrangement, Configuration, Source};
use etendue::estimator::{Job, Scratch, for_technique};
use etendue::geometry::{
    DVec3, Disk, MapTriangle, Mesh, Parametrisation, Polygon, Rectangle, Shape, Sphere, TexelGrid,
};
use etendue::oracle::Oracle;
use etendue::oracle::optics::{MirrorOracle, PlaneMirror};
use etendue::oracle::patch::{Patch, Tolerance};
use etendue::sampling::{Purpose, Strategy, StreamKey};
use etendue::texture::{ExitancePolynomial, Lookup, OnRectangle, Raster, Texels, Texture};
use etendue::trial::{Effort, Overrides, Settings};

use super::{Change, SAME, assert_near, assert_sound, bound, irradiance, point, room, truth};

/// All coordinates below are multiples of 2⁻⁸ m: added to these, nothing is rounded.
const FAR: [f64; 2] = [(1 << 20) as f64, (1 << 30) as f64];

fn polygon(origin: DVec3, corners: &[[f64; 2]], z: f64) -> Shape {
    let corners = corners.iter().map(|[x, y]| origin + DVec3::new(*x, *y, z));
    Shape::Polygon(Polygon::new(corners.collect()).unwrap())
}

/// Lit downwards, one of each kind.
fn sources(o: DVec3) -> [Shape; 4] {
    [
        Shape::Disk(Disk::new(o + DVec3::Z * 2.0, DVec3::NEG_Z, 0.5).unwrap()),
        Shape::Rectangle(Rectangle::new(o + DVec3::new(0.25, 0.0, 2.0), DVec3::Y, DVec3::X * 0.75).unwrap()),
        polygon(o, &[[-0.5, -0.5], [-0.5, 0.5], [0.0, 0.5], [0.0, 0.0], [0.5, 0.0], [0.5, -0.5]], 2.0),
        Shape::Sphere(Sphere::new(o + DVec3::new(0.0, 0.25, 2.0), 0.375).unwrap()),
    ]
}

/// One of each kind.
fn occluders(o: DVec3) -> [Shape; 5] {
    let cone = [[0.5, 0.0, 1.25], [0.25, -0.25, 1.0], [0.75, -0.25, 1.0], [0.75, 0.25, 1.0], [0.25, 0.25, 1.0]];
    let sides = (1..5).map(|k| [0, k, 1 + k % 4]).collect();
    [
        Shape::Disk(Disk::new(o + DVec3::new(-0.125, 0.0, 1.0), DVec3::Z, 0.25).unwrap()),
        Shape::Rectangle(Rectangle::new(o + DVec3::new(0.25, 0.0, 0.75), DVec3::X * 0.5, DVec3::Y * 0.25).unwrap()),
        polygon(o, &[[-0.5, 0.25], [0.0, 0.25], [-0.25, 0.75]], 1.25),
        Shape::Sphere(Sphere::new(o + DVec3::new(-0.5, -0.375, 1.0), 0.1875).unwrap()),
        Shape::Mesh(Mesh::new(cone.map(|c| o + DVec3::from(c)).to_vec(), sides).unwrap()),
    ]
}

fn far_room(o: DVec3, source: usize, occluders: &[Shape]) -> Configuration {
    let points =
        (0..12).map(|k| point(o + DVec3::new(f64::from(k) / 4.0 - 1.25, f64::from(k) / 64.0, 0.0), DVec3::Z));
    room(vec![(sources(o)[source].clone(), 1.0)], occluders.to_vec(), points.collect())
}

#[test]
fn a_room_is_the_same_room_wherever_it_stands() {
    let mut partly = 0;
    for far in FAR {
        let o = DVec3::new(far, -far, far);
        for source in 0..4 {
            for kinds in [0..1, 1..2, 2..3, 3..4, 4..5, 0..5] {
                let here = far_room(DVec3::ZERO, source, &occluders(DVec3::ZERO)[kinds.clone()]);
                let there = far_room(o, source, &occluders(o)[kinds.clone()]);
                let [a, b] = [&here, &there].map(Oracle::new);
                for (p, q) in here.points().iter().zip(there.points()) {
                    let (a, b) = (a.at(p), b.at(q));
                    let what = format!("{far:e} source {source} occluders {kinds:?}\n{a:?}\n{b:?}");
                    assert!((irradiance(&a) - irradiance(&b)).abs() <= bound(&a) + bound(&b), "{what}");
                    assert!(bound(&b) <= 1e-11, "{what}");
                    assert_eq!(a.region, b.region, "{what}");
                    partly += u32::from(a.shadow_edge);
                }
            }
        }
    }
    assert!(partly > 100, "{partly}");
}

/// Sources whose exitance varies, one of each kind and lookup; a rectangle with a polynomial, too.
fn textured(o: DVec3) -> Vec<Source> {
    let [disk, rectangle, _, sphere] = sources(o);
    let corners = [[-0.5, -0.25], [-0.25, 0.5], [0.75, -0.25]].map(|[x, y]| o + DVec3::new(x, y, 2.0));
    let triangle = Shape::Polygon(Polygon::new(corners.to_vec()).unwrap());
    let maps = [disk, rectangle.clone(), triangle, sphere].map(|shape| {
        let map = match &shape {
            Shape::Disk(disk) => Parametrisation::disk(disk, None).unwrap(),
            Shape::Rectangle(rectangle) => Parametrisation::rectangle(rectangle),
            Shape::Sphere(sphere) => Parametrisation::sphere(sphere, DVec3::new(0.5, 0.25, 1.0), DVec3::X).unwrap(),
            _ => {
                Parametrisation::triangle(corners, MapTriangle::new([[0.0, 0.0], [1.0, 0.25], [0.25, 1.0]]).unwrap())
                    .unwrap()
            }
        };
        (shape, map)
    });
    let raster = Raster::checker(TexelGrid::new(3, 2).unwrap(), 2.0, 0.25).unwrap();
    let mut all = Vec::new();
    for lookup in [Lookup::Nearest, Lookup::Bilinear] {
        for (shape, map) in &maps {
            let texture = Texture::Texels(Texels::new(*map, raster.clone(), lookup));
            all.push(Source::textured(shape.clone(), texture).unwrap());
        }
    }
    let Shape::Rectangle(panel) = &rectangle else { unreachable!("it is one") };
    let bulge = ExitancePolynomial { e00: 1.0, e10: 0.25, e11: 0.125, e20: -0.5, ..Default::default() };
    let texture = Texture::Polynomial(OnRectangle::new(*panel, bulge).unwrap());
    all.push(Source::textured(rectangle, texture).unwrap());
    all
}

/// Found by this test: textures were read by absolute positions, whose roundings, a thousand kilometres off, no quadrature
/// gets below; a point took seconds, and its bound held none of them.
#[test]
fn a_texture_is_the_same_texture_wherever_it_hangs() {
    for far in FAR {
        let o = DVec3::new(far, -far, far);
        for k in 0..textured(DVec3::ZERO).len() {
            for kinds in [0..0, 1..2, 3..4] {
                let rooms = [DVec3::ZERO, o].map(|o| {
                    let source = textured(o).swap_remove(k);
                    let points =
                        (0..4).map(|k| point(o + DVec3::new(f64::from(k) / 2.0 - 0.75, 0.125, 0.0), DVec3::Z));
                    let occluders = occluders(o)[kinds.clone()].to_vec();
                    Configuration::new(vec![source], occluders, None, points.collect(), Arrangement::Scattered)
                        .unwrap()
                });
                let [here, there] = rooms.each_ref().map(Oracle::new);
                for (p, q) in rooms[0].points().iter().zip(rooms[1].points()) {
                    let (a, b) = (here.at(p), there.at(q));
                    let what = format!("{far:e} texture {k} occluders {kinds:?}\n{a:?}\n{b:?}");
                    assert!((irradiance(&a) - irradiance(&b)).abs() <= bound(&a) + bound(&b), "{what}");
                    assert!(bound(&b) <= 1e-11, "{what}");
                }
            }
        }
    }
}

#[test]
fn an_estimate_is_the_same_wherever_its_room_stands() {
    for source in 0..4 {
        let o = DVec3::new(FAR[0], -FAR[0], FAR[0]);
        let rooms = [DVec3::ZERO, o].map(|o| far_room(o, source, &occluders(o)));
        for strategy in Strategy::ALL {
            let cell = StreamKey::cell(7, 2, Purpose::Measurement, strategy, 64);
            let [here, there] = rooms.each_ref().map(|room| {
                let mut estimates = vec![f64::NAN; room.points().len()];
                let job = Job { strategy, samples: 64, cell, replicates: 0..1, points: room.points() };
                for_technique(room, strategy.technique()).estimate(&job, &mut Scratch::default(), &mut estimates);
                estimates
            });
            for (a, b) in here.iter().zip(&there) {
                // Places on the source are off by roundings of 10⁶ m, 10⁻¹⁰ m.
                assert!((a - b).abs() <= 1e-8 * a, "source {source} {strategy}: {a:e} {b:e}");
            }
        }
    }
}

/// Found by this test: the rounding of the mirrored eye was in no bound, and an average, which cannot be better than that,
/// was refined for hours.
#[test]
fn what_is_seen_in_a_mirror_does_not_depend_on_where_the_room_stands() {
    let seen = |o: DVec3| {
        let lamp = Rectangle::new(o + DVec3::Z, DVec3::X * 0.5, DVec3::Y * 0.5).unwrap();
        let glass = Rectangle::new(o + DVec3::new(0.25, 0.0, 2.0), DVec3::X * 2.0, DVec3::Y * 1.5).unwrap();
        let points = (0..16).map(|k| point(o + DVec3::new(f64::from(k) / 16.0, 0.25, 0.0), DVec3::Z)).collect();
        let room = room(vec![(Shape::Rectangle(lamp), 1.0)], vec![], points);
        let oracle = MirrorOracle::new(&room, &PlaneMirror::new(Shape::Rectangle(glass), 0.75).unwrap()).unwrap();
        // From here the lamp is seen whole, or hidden in part by itself.
        let floor = Rectangle::new(o + DVec3::X * 0.5, DVec3::X * 0.25, DVec3::Y * 0.25).unwrap();
        let mean = oracle.average_irradiance(&Patch::Rectangle(floor), Tolerance::relative(1e-9));
        (room.points().iter().map(|p| oracle.at(p).unwrap()).collect::<Vec<_>>(), mean)
    };
    let (here, mean) = seen(DVec3::ZERO);
    for far in FAR {
        let (there, far_mean) = seen(DVec3::new(far, -far, far));
        for (a, b) in here.iter().zip(&there) {
            let [(x, dx), (y, dy)] =
                [a, b].map(|t| (t.irradiance.watts_per_square_metre(), t.bound.watts_per_square_metre()));
            assert!((x - y).abs() <= dx + dy, "{a:?}\n{b:?}");
        }
        let [(x, dx), (y, dy)] =
            [mean, far_mean].map(|t| (t.irradiance.watts_per_square_metre(), t.bound.watts_per_square_metre()));
        assert!((x - y).abs() <= dx + dy && dy < 1e-11 * far * y, "{mean:?}\n{far_mean:?}");
        assert!(far_mean.evaluations < 4 * mean.evaluations, "{mean:?}\n{far_mean:?}");
    }
}

/// Rays from the light, eye paths and estimates, judged a thousand kilometres off.
#[test]
fn rooms_far_from_the_origin_pass() {
    let names = [
        "texture/blended-panel",
        "texture/tiled-ball",
        "caustic/glass-ball",
        "caustic/paraboloid",
        "interreflection/furnace-with-glass",
        "interreflection/lampshade",
        "penumbra/three-regions",
    ];
    let overrides = Overrides { samples: Some(vec![1, 9]), ..Overrides::default() };
    let settings = Settings { seed: 4, effort: Effort::Quick, overrides };
    let change = Change { shift: FAR[0], ..SAME };
    let cases = names.map(|name| change.case(name).unwrap_or_else(|mistakes| panic!("{mistakes}")));
    assert_sound("far", &cases, &settings);
}

/// R²/(R² + h²) of a disk straight above, from a micrometre to beyond Neptune.
#[test]
fn a_lamp_may_be_as_far_away_as_one_likes() {
    for height in [1e-12, 1e-6, 1e6, 1e12, 1e20] {
        for radius in [1e-6, 1.0, 1e6] {
            let lamp = Shape::Disk(Disk::new(DVec3::Z * height, DVec3::NEG_Z, radius).unwrap());
            let ratio = height / radius;
            if ratio < 1e-14 {
                continue; // On the lamp, as far as its coordinates tell.
            }
            let found = truth(lamp, vec![], DVec3::ZERO, DVec3::Z);
            assert_near(&format!("{radius:e} m at {height:e} m"), &found, 1.0 / (1.0 + ratio * ratio), 1e-14);
        }
    }
    let lamp = Disk::new(DVec3::Z * 1e30, DVec3::NEG_Z, 1e-6).unwrap();
    let source = etendue::configuration::Source::new(Shape::Disk(lamp), etendue::radiometry::Exitance::new(1.0));
    let refused = Configuration::new(
        vec![source.unwrap()],
        vec![],
        None,
        vec![point(DVec3::X, DVec3::Z), point(DVec3::ZERO, DVec3::Z)],
        etendue::configuration::Arrangement::Scattered,
    );
    let told: Vec<String> = refused.unwrap_err().iter().map(ToString::to_string).collect();
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(
        told[0].starts_with("at measurement point 0 (and 1 more)") && told[0].contains("1e-60 or more"),
        "{told:?}"
    );
}
