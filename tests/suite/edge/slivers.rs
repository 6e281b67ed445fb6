//! Needles, slivers and hairs: closed values where all but one length is tiny.

use std::f64::consts::PI;

use etendue::case::{Replicates, Study};
use etendue::configuration::Configuration;
use etendue::geometry::{DVec3, Disk, Mesh, Polygon, Rectangle, Shape, Sphere};
use etendue::oracle::{Oracle, Region};
use etendue::trial::{self, Effort, Overrides, Settings};
use etendue::{Case, Verdict};

use super::{assert_near, assert_tables, bound, irradiance, point, room, shown, to_parallel_disk, truth};

const TINY: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

fn disk(center: DVec3, normal: DVec3, radius: f64) -> Shape {
    Shape::Disk(Disk::new(center, normal, radius).unwrap())
}

/// Of a strip of width w and length 2aH over the origin at height H, parallel: w/(πH) (a/(1 + a²) + arctan a), and a share
/// w²/H² of that less.
fn needle(width: f64, length: f64, height: f64) -> f64 {
    let a = 0.5 * length / height;
    width / (PI * height) * (a / (1.0 + a * a) + a.atan())
}

#[test]
fn a_needle_is_a_line_of_light() {
    for width in TINY {
        let (length, height) = (1.5, 0.75);
        let expected = needle(width, length, height);
        let half = DVec3::new(0.5 * length, 0.0, height);
        let w = DVec3::Y * (0.5 * width);
        let corners = [
            half + w,
            half - w,
            DVec3::Z * height - DVec3::X * half.x - w,
            DVec3::Z * height - DVec3::X * half.x + w,
        ];
        let sources = [
            Shape::Rectangle(Rectangle::new(DVec3::Z * height, DVec3::Y * width, DVec3::X * length).unwrap()),
            Shape::Polygon(Polygon::new(corners.to_vec()).unwrap()),
        ];
        for source in sources {
            let found = truth(source, vec![], DVec3::ZERO, DVec3::Z);
            assert!(
                (irradiance(&found) - expected).abs() <= width * width * expected + bound(&found),
                "{width}: {found:?}"
            );
            assert!(bound(&found) <= 1e-2 * expected.min(1e-12 / width), "{width}: {found:?}, {expected:e}");
        }
    }
}

/// A triangle of no width to speak of brings half of what the strip does that it is the half of.
#[test]
fn slivers_of_a_polygon_add_up() {
    for width in TINY {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let (a, b, c, d) = (corner(-0.5, 0.0), corner(0.5, 0.0), corner(0.5, width), corner(-0.5, width));
        let of = |corners: &[DVec3]| {
            let corners = corners.iter().rev().copied().collect();
            truth(Shape::Polygon(Polygon::new(corners).unwrap()), vec![], DVec3::new(0.25, 0.0, 0.0), DVec3::Z)
        };
        let (whole, halves) = (of(&[a, b, c, d]), [of(&[a, b, c]), of(&[a, c, d])]);
        let sum = irradiance(&halves[0]) + irradiance(&halves[1]);
        let bounds = bound(&whole) + bound(&halves[0]) + bound(&halves[1]);
        assert!((irradiance(&whole) - sum).abs() <= bounds + 1e-15 * sum, "{width}: {whole:?} {halves:?}");
        assert!(irradiance(&halves[0]) > 0.3 * sum && irradiance(&halves[1]) > 0.1 * sum, "{halves:?}");
    }
}

/// Light between a lamp and an occluder that hides it but for a hair all around.
#[test]
fn a_ring_of_light_as_thin_as_a_hair_is_the_rest() {
    for gap in TINY {
        // Seen from the origin, a disk at half the height looks twice as large.
        let (height, radius) = (2.0, 0.5);
        let hidden = 0.5 * radius * (1.0 - gap);
        let found = truth(
            disk(DVec3::Z * height, DVec3::NEG_Z, radius),
            vec![disk(DVec3::Z * (0.5 * height), DVec3::Z, hidden)],
            DVec3::ZERO,
            DVec3::Z,
        );
        // R²/(R² + h²) less the same of the shadow: with the radius as it was rounded, no difference of near-equal numbers.
        let shadow = 2.0 * hidden;
        let (r2, s2, h2) = (radius * radius, shadow * shadow, height * height);
        let expected = (radius - shadow) * (radius + shadow) * h2 / ((r2 + h2) * (s2 + h2));
        assert!((irradiance(&found) - expected).abs() <= bound(&found) + 1e-15 * expected, "{gap}: {found:?}");
        assert!(bound(&found) <= 2e-14, "{gap}: {found:?}");
        assert_eq!(found.region, Region::Penumbra, "{gap}");
    }
}

/// Beside a lamp, a hair above its plane: what arrives is in proportion to the hair.
#[test]
fn a_hair_above_a_lamps_plane_sees_a_hair_of_it() {
    // ∫ over the disk of (d − x)/(π r⁴), the slope at no height: R²/(d (d² − R²)).
    let apart: f64 = 2.0;
    let slope = 1.0 / (apart * (apart * apart - 1.0));
    for height in [1e-3, 1e-6, 1e-9, 1e-12] {
        let found = truth(disk(DVec3::ZERO, DVec3::Z, 1.0), vec![], DVec3::new(apart, 0.0, height), DVec3::NEG_X);
        let expected = slope * height;
        assert!(
            (irradiance(&found) - expected).abs() <= bound(&found) + height * height * expected,
            "{height}: {found:?} {expected:e}"
        );
        assert!(bound(&found) <= 1e-14, "{height}: {found:?}");
        let below = truth(disk(DVec3::ZERO, DVec3::Z, 1.0), vec![], DVec3::new(apart, 0.0, -height), DVec3::NEG_X);
        assert_eq!((irradiance(&below), below.region), (0.0, Region::BelowHorizon), "{height}");
    }
}

/// A hair before the middle of a lamp everything is lamp.
#[test]
fn a_hair_before_a_lamp_all_is_light() {
    for height in [1e-3, 1e-6, 1e-9, 1e-12] {
        let found = truth(disk(DVec3::ZERO, DVec3::Z, 1.0), vec![], DVec3::Z * height, DVec3::NEG_Z);
        assert_near(&format!("{height}"), &found, 1.0 / (1.0 + height * height), 1e-14);
        let ball = Shape::Sphere(Sphere::new(DVec3::ZERO, 1.0).unwrap());
        let found = truth(ball, vec![], DVec3::Z * (1.0 + height), DVec3::NEG_Z);
        let distance = 1.0 + height;
        assert_near(&format!("{height}"), &found, 1.0 / (distance * distance), 1e-14);
    }
}

/// A lamp of a micrometre in a room of a thousand kilometres, and a wall of that size with a hole around the way.
#[test]
fn sizes_that_have_nothing_in_common_stand_in_one_room() {
    let lamp = disk(DVec3::Z, DVec3::NEG_Z, 1e-6);
    let wall =
        |x: f64| Shape::Rectangle(Rectangle::new(DVec3::new(x, 0.0, 0.5), DVec3::X * 1e6, DVec3::Y * 1e6).unwrap());
    let beside = 0.25;
    let expected = to_parallel_disk(1.0, beside, 1e-6);
    let at = DVec3::X * beside;
    assert_near("alone", &truth(lamp.clone(), vec![], at, DVec3::Z), expected, 1e-13);
    // The wall ends at x = 0.1249, the way crosses its plane at 0.125 ± 5·10⁻⁷.
    let open = truth(lamp.clone(), vec![wall(-5e5 + 0.1249)], at, DVec3::Z);
    assert_eq!(open.region, Region::Lit);
    assert!((irradiance(&open) - expected).abs() <= bound(&open), "{open:?}");
    assert_eq!(truth(lamp.clone(), vec![wall(-5e5 + 0.1251)], at, DVec3::Z).region, Region::Umbra);
    // Light of all sizes together is their sum.
    let far = disk(DVec3::Z * 1e9, DVec3::NEG_Z, 1e6);
    let both = room(vec![(lamp, 1e12), (far, 1.0)], vec![], vec![point(at, DVec3::Z)]);
    let found = Oracle::new(&both).at(&both.points()[0]);
    assert_near("both", &found, 1e12 * expected + to_parallel_disk(1e9, beside, 1e6), 1e-13);
}

fn judged(configuration: Configuration, replicates: u64) -> Vec<(String, Verdict, String)> {
    let case = Case::new("hair", "A hair", configuration, Study::default());
    let overrides = Overrides {
        samples: Some(vec![1, 16]),
        replicates: Some(Replicates::Fixed(replicates)),
        ..Overrides::default()
    };
    let settings = Settings { seed: 8, effort: Effort::Quick, overrides };
    let outcome = trial::run(&[case], &settings, &|_| {}).unwrap();
    assert_tables("hair", &outcome);
    shown(&outcome)
}

/// What can be told of a sliver is told right; where samples seldom find the light, nothing is claimed, and nothing denied.
#[test]
fn estimates_of_slivers_pass_and_of_hairs_never_fail() {
    let o = DVec3::ZERO;
    let needle = Shape::Rectangle(Rectangle::new(DVec3::Z, DVec3::Y * 1e-9, DVec3::X).unwrap());
    let triangle = [[0.5, 1e-9], [0.5, 0.0], [-0.5, 0.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let sliver = Shape::Polygon(Polygon::new(triangle.to_vec()).unwrap());
    let micro = disk(DVec3::Z, DVec3::NEG_Z, 1e-6);
    let plate = [[-1e6, -1e6], [0.125, -1e6], [0.125, 1e6], [-1e6, 1e6]].map(|[x, y]| DVec3::new(x, y, 0.5));
    let mesh = Shape::Mesh(Mesh::new(plate.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap());
    let cases = [
        ("needle", needle, vec![], o),
        ("sliver", sliver, vec![], o),
        ("a lamp of a micrometre, half of it behind a wall", micro, vec![mesh], DVec3::X * 0.25),
        ("far", disk(DVec3::Z * 1e12, DVec3::NEG_Z, 1.0), vec![], o),
    ];
    for (what, source, occluders, at) in cases {
        for (name, verdict, words) in judged(room(vec![(source, 1.0)], occluders, vec![point(at, DVec3::Z)]), 40_000)
        {
            assert_eq!(verdict, Verdict::Pass, "{what}: {name}: {words}");
        }
    }
    let lamp = || disk(DVec3::ZERO, DVec3::Z, 1.0);
    let hairs = [
        ("before it", lamp(), vec![], DVec3::Z * 1e-6, DVec3::NEG_Z),
        ("above its plane", lamp(), vec![], DVec3::new(2.0, 0.0, 1e-12), DVec3::NEG_X),
        ("a ring", disk(DVec3::Z * 2.0, DVec3::NEG_Z, 0.5), vec![disk(DVec3::Z, DVec3::Z, 0.25 - 1e-9)], o, DVec3::Z),
    ];
    for (what, source, occluders, at, normal) in hairs {
        for (name, verdict, words) in judged(room(vec![(source, 1.0)], occluders, vec![point(at, normal)]), 512) {
            assert_ne!(verdict, Verdict::Fail, "{what}: {name}: {words}");
        }
    }
}
