//! Rays from the light against closed forms: where the flux lands, how much of it, and that none is lost.
//!
//! Nothing here uses the exact side's text: each expected value is written down again, or copied from the certified tables.

use std::f64::consts::PI;

use etendue::case::shipped_caustics;
use etendue::configuration::{
    Configuration, Contents, DiffuseSurface, Glass, GlassShape, Lamp, Mirror, MirrorShape, Receiver, ReceiverShape,
    Source,
};
use etendue::geometry::{DVec3, Disk, Paraboloid, Rectangle, Shape, Slab, Sphere, SphereCap};
use etendue::light::{Aim, Light, LightRun, LightSettings, Rings, Split, trace};
use etendue::radiometry::{Albedo, Beam, Exitance, Flux, Irradiance, PointSource};
use etendue::statistics::budget::{plausible, seed_of};

/// Two-sided, in standard errors: normal tails beyond it are below the budget of a test, many times over.
const FAR: f64 = 6.0;

fn square(z: f64, side: f64, up: bool) -> Rectangle {
    let v = if up { DVec3::Y } else { -DVec3::Y };
    Rectangle::new(DVec3::Z * z, DVec3::X * side, v * side).unwrap()
}

fn screen(z: f64, side: f64, up: bool) -> Option<Receiver> {
    Some(Receiver::new(ReceiverShape::Rectangle(square(z, side, up)), None).unwrap())
}

fn beam(from: DVec3, direction: DVec3, radius: f64) -> Lamp {
    Lamp::Beam(Beam::new(from, direction, radius, Irradiance::new(1.0)).unwrap())
}

fn ball(radius: f64, ior: f64) -> Glass {
    Glass::new(GlassShape::Sphere(Sphere::new(DVec3::ZERO, radius).unwrap()), ior).unwrap()
}

fn room(contents: Contents) -> Configuration {
    Configuration::of(contents).unwrap_or_else(|mistakes| panic!("{mistakes:?}"))
}

/// Unaimed, one part at each face: all packets are alike, and what lands is a count.
fn plain(rays: u64) -> LightSettings {
    LightSettings { rays, aim: Aim::Nowhere, split: Split::One, map: [16, 16], ..LightSettings::default() }
}

/// How many equal packets make up a flux.
fn packets(flux: f64, run: &LightRun) -> u64 {
    let count = flux / (run.ledger.emitted / run.ledger.rays as f64);
    assert!((count - count.round()).abs() < 1e-6 * (1.0 + count), "{count} packets");
    count.round() as u64
}

/// Fresnel's power reflectances by the textbook, from a relative index and the sine and cosine of arrival.
fn fresnel(n: f64, sine: f64, cosine: f64) -> [f64; 2] {
    let t = (1.0 - (sine / n) * (sine / n)).max(0.0).sqrt();
    let (s, p) = ((cosine - n * t) / (cosine + n * t), (n * cosine - t) / (n * cosine + t));
    [s * s, p * p]
}

fn assert_sound(name: &str, run: &LightRun) {
    let ledger = &run.ledger;
    assert!(ledger.relative_residual() <= 1e-12, "{name}: {:e} of {ledger:?}", ledger.relative_residual());
    assert!((ledger.emitted / ledger.source_power - 1.0).abs() <= 1e-12, "{name}: {ledger:?}");
    let on_maps: f64 = run.maps.iter().map(|map| map.total(Light::Both)).sum();
    assert!((on_maps - ledger.deposited).abs() <= 1e-12 * ledger.emitted, "{name}: {on_maps} {ledger:?}");
    let by_order: f64 = (0..=run.depth()).map(|order| run.deposited_by_order(order)).sum();
    assert!((by_order - ledger.deposited).abs() <= 1e-12 * ledger.emitted, "{name}");
    let bent: f64 = run.maps.iter().map(|map| map.total(Light::Bent)).sum();
    assert!((ledger.deposited - bent - run.deposited_by_order(0)).abs() <= 1e-12 * ledger.emitted, "{name}");
}

#[test]
fn the_books_of_every_shipped_case_balance() {
    let mut read = 0;
    for shipped in shipped_caustics() {
        let case = shipped.read().unwrap_or_else(|mistakes| panic!("{mistakes}"));
        for split in Split::ALL {
            for aim in Aim::ALL {
                let light = LightSettings { rays: 20_000, split, aim, ..case.light.clone() };
                let run = trace(&case.configuration, &light, 1);
                assert_sound(&case.name, &run);
                assert!(run.ledger.rays >= 20_000, "{}: {}", case.name, run.ledger.rays);
                assert!(run.reached.iter().all(|reached| *reached > 0), "{}: {:?}", case.name, run.reached);
                assert!(run.ledger.deposited > 0.0, "{}", case.name);
            }
        }
        read += 1;
    }
    assert!(read >= 8, "{read} cases");
}

#[test]
fn aim_and_split_move_no_light() {
    let seed = seed_of("aim_and_split_move_no_light");
    for shipped in shipped_caustics() {
        let case = shipped.read().unwrap_or_else(|mistakes| panic!("{mistakes}"));
        let run = |aim, split, seed| {
            trace(&case.configuration, &LightSettings { rays: 60_000, aim, split, ..case.light.clone() }, seed)
        };
        let runs = [
            run(Aim::Nowhere, Split::One, seed),
            run(Aim::Optics, Split::One, seed + 1),
            run(Aim::Optics, Split::Both, seed + 2),
            run(Aim::Nowhere, Split::Both, seed + 3),
        ];
        for other in &runs[1..] {
            for order in 0..4 {
                let (a, b) = (runs[0].deposited(0, order), other.deposited(0, order));
                let spread = a.variance(runs[0].ledger.groups).unwrap() + b.variance(other.ledger.groups).unwrap();
                let apart = (a.watts() - b.watts()).abs();
                // What is rare leaves a few packets, whose spread is not told by themselves: Poisson's is the packets'.
                let packet = runs[0].ledger.emitted / runs[0].ledger.rays as f64;
                let bound = FAR * (spread + packet * packet * 9.0).sqrt();
                assert!(apart <= bound, "{} order {order}: {} {}", case.name, a.watts(), b.watts());
            }
        }
        // The aim pays: the bent light is better known.
        let bent = |run: &LightRun| -> f64 {
            (1..=run.depth()).map(|order| run.deposited(0, order).variance(run.ledger.groups).unwrap()).sum()
        };
        // Where all light is bent, once and for all of it, nothing varies.
        let [plain, aimed] = [bent(&runs[0]), bent(&runs[1])];
        assert!(plain >= 0.7 * aimed, "{}: the variance was {plain}, and is {aimed}", case.name);
    }
}

/// Rows of the certified table `caustic_bins`: radius, distance of the plane, beam radius, ring, its power and all power over
/// the irradiance.
#[test]
fn rings_under_a_spherical_mirror_have_their_power() {
    let seed = seed_of("rings_under_a_spherical_mirror_have_their_power");
    for (k, (radius, zp, beam_radius, inner, outer, power)) in [
        (1.875, 0.52734375, 0.76171875, 0.054931640625, 0.194091796875, 0.544_749_519_619_178_7),
        (1.375, 0.55859375, 0.515625, 0.002685546875, 0.23095703125, 0.834_607_890_727_548_1),
        (1.625, 0.45703125, 0.76171875, 0.047607421875, 0.136474609375, 0.260_689_082_269_958_35),
    ]
    .into_iter()
    .enumerate()
    {
        let sphere = Sphere::new(DVec3::Z * radius, radius).unwrap();
        let bowl = SphereCap::new(sphere, -DVec3::Z, 0.5 * (beam_radius + radius)).unwrap();
        let room = room(Contents {
            lamps: vec![beam(DVec3::Z * 9.0, -DVec3::Z, beam_radius)],
            mirrors: vec![Mirror::new(MirrorShape::SphereCap(bowl), 1.0).unwrap()],
            receiver: screen(zp, 9.0, false),
            ..Contents::default()
        });
        let within = |radius: f64| {
            let rings = Some(Rings { center: DVec3::Z * zp, radius, count: 1 });
            let run = trace(&room, &LightSettings { rings, ..plain(200_000) }, seed + k as u64);
            packets(run.rings.as_ref().unwrap().moments(1, 0).watts(), &run)
        };
        let share = power / (PI * beam_radius * beam_radius);
        let found = within(outer) - within(inner);
        assert!(plausible(found, 200_000, share, share), "{radius}: {found} of {}", share * 200_000.0);
    }
}

#[test]
fn rings_under_a_glass_ball_have_their_power() {
    let seed = seed_of("rings_under_a_glass_ball_have_their_power");
    for (k, (radius, ior, q, beam_radius, inner, outer, power, total)) in [
        (
            1.0,
            1.484375,
            2.140625,
            0.421875,
            0.037109375,
            0.154296875,
            0.306_939_356_139_572_9,
            0.517_232_375_553_590_7,
        ),
        (
            1.25,
            1.671875,
            1.9140625,
            0.703125,
            0.04638671875,
            0.14404296875,
            0.570_227_399_702_323_7,
            1.360_637_573_893_478,
        ),
        (
            0.875,
            1.75,
            1.162109375,
            0.6015625,
            0.02734375,
            0.1162109375,
            0.527_818_380_578_172_2,
            0.969_468_746_559_111_6,
        ),
        (
            0.75,
            1.875,
            1.078125,
            0.46875,
            0.01611328125,
            0.03076171875,
            0.014_649_629_410_054_525,
            0.566_792_218_461_124_5,
        ),
    ]
    .into_iter()
    .enumerate()
    {
        let room = room(Contents {
            lamps: vec![beam(DVec3::Z * 3.0, -DVec3::Z, beam_radius)],
            glass: vec![ball(radius, ior)],
            receiver: screen(-q, 60.0, true),
            ..Contents::default()
        });
        let run = |radius: f64| {
            let rings = Some(Rings { center: DVec3::Z * -q, radius, count: 1 });
            trace(&room, &LightSettings { rings, ..plain(200_000) }, seed + k as u64)
        };
        let within = |run: &LightRun| packets(run.rings.as_ref().unwrap().moments(2, 0).watts(), run);
        let wide = run(outer);
        let found = within(&wide) - within(&run(inner));
        let section = PI * beam_radius * beam_radius;
        assert!(plausible(found, 200_000, power / section, power / section), "{k}: {found}");
        let through = packets(wide.deposited(0, 2).watts(), &wide);
        assert!(plausible(through, 200_000, total / section, total / section), "{k}: {through}");
        assert_eq!(wide.depolarised, 0, "through the axis every path stays in its plane");
    }
}

/// A slanting beam through a plate: what goes straight through is known for each ray, so it is known to rounding.
#[test]
fn both_polarisations_go_through_a_plate_by_themselves() {
    let direction = DVec3::new(3f64.sqrt(), 0.0, -1.0).normalize();
    let plate = Slab::new(square(1.0, 100.0, true), 0.5).unwrap();
    let room = room(Contents {
        lamps: vec![beam(DVec3::Z * 3.0, direction, 0.5)],
        glass: vec![Glass::new(GlassShape::Slab(plate), 1.5).unwrap()],
        receiver: screen(0.0, 100.0, true),
        ..Contents::default()
    });
    let [rs, rp] = fresnel(1.5, 0.75f64.sqrt(), 0.5);
    let power = PI * 0.25;
    let run = trace(&room, &LightSettings { split: Split::Both, ..plain(20_000) }, 7);
    // The mean of the products, not the product of the means: 0.8355 and not 0.8296.
    let first = 0.5 * ((1.0 - rs) * (1.0 - rs) + (1.0 - rp) * (1.0 - rp));
    assert!((run.deposited(0, 2).watts() / (power * first) - 1.0).abs() < 1e-12, "{}", run.deposited(0, 2).watts());
    let unpolarised = (1.0 - 0.5 * (rs + rp)).powi(2);
    assert!((first - unpolarised).abs() > 0.005);
    // After one echo, two reflections more.
    let second = 0.5 * ((1.0 - rs).powi(2) * rs * rs + (1.0 - rp).powi(2) * rp * rp);
    assert!((run.deposited(0, 4).watts() / (power * second) - 1.0).abs() < 1e-11);
    // With all echoes (1 − R)/(1 + R) gets through for each.
    let all = 0.5 * ((1.0 - rs) / (1.0 + rs) + (1.0 - rp) / (1.0 + rp));
    let off = (run.ledger.deposited - power * all).abs();
    assert!(off <= FAR * run.ledger.deposited_std_error.unwrap() + 1e-9, "{off:e}");
    assert_sound("plate", &run);
    // One part at a time: a count.
    let run = trace(&room, &plain(200_000), seed_of("both_polarisations_go_through_a_plate_by_themselves"));
    let through = packets(run.deposited(0, 2).watts(), &run);
    assert!(plausible(through, 200_000, first, first), "{through} of {}", first * 200_000.0);
}

/// A paraboloid sends what hits it between two radii into the ring between their images, all of it.
#[test]
fn a_paraboloid_maps_rings_to_rings() {
    let seed = seed_of("a_paraboloid_maps_rings_to_rings");
    let dish = Paraboloid::new(DVec3::ZERO, DVec3::Z, 1.0, 1.2).unwrap();
    let room = room(Contents {
        lamps: vec![beam(DVec3::Z * 3.0, -DVec3::Z, 1.0)],
        mirrors: vec![Mirror::new(MirrorShape::Paraboloid(dish), 0.75).unwrap()],
        receiver: screen(0.5, 9.0, false),
        ..Contents::default()
    });
    let rings = Rings { center: DVec3::Z * 0.5, radius: 0.7, count: 14 };
    let run = trace(&room, &LightSettings { rings: Some(rings), ..plain(200_000) }, seed);
    assert!((run.ledger.deposited / (0.75 * PI) - 1.0).abs() < 1e-12, "none misses: {:?}", run.ledger);
    assert!((run.ledger.absorbed / (0.25 * PI) - 1.0).abs() < 1e-12);
    // rho = 2 f kap s/(1 − s²) with kap = 1/2, r = 2 f s.
    let radius = |rho: f64| 2.0 * rho / (0.5 + 0.5f64.hypot(rho));
    for ring in 0..14 {
        let [inner, outer] = rings.radii(ring).map(|rho| radius(rho).min(1.0));
        let share = outer * outer - inner * inner;
        let watts = run.rings.as_ref().unwrap().moments(1, ring).watts() / 0.75;
        let found = packets(watts, &run);
        assert!(plausible(found, 200_000, share, share), "ring {ring}: {found} of {}", share * 200_000.0);
    }
}

/// A disk, a mirror over it, and a disk between the two that lets light pass from behind: the form factor of two coaxial
/// disks at the distance of the image.
#[test]
fn a_plane_mirror_moves_the_source_to_its_image() {
    let seed = seed_of("a_plane_mirror_moves_the_source_to_its_image");
    let source = Disk::new(DVec3::ZERO, DVec3::Z, 0.5).unwrap();
    let receiver = Disk::new(DVec3::Z, DVec3::Z, 0.8).unwrap();
    let room = room(Contents {
        sources: vec![Source::new(Shape::Disk(source), Exitance::new(2.0)).unwrap()],
        mirrors: vec![Mirror::new(MirrorShape::Rectangle(square(2.0, 50.0, true)), 0.8).unwrap()],
        receiver: Some(Receiver::new(ReceiverShape::Disk(receiver), None).unwrap()),
        ..Contents::default()
    });
    let (r1, r2, h) = (0.5f64, 0.8f64, 3.0f64);
    let factor = 2.0 * r2 * r2 / (h * h + r1 * r1 + r2 * r2 + h.hypot(r1 - r2) * h.hypot(r1 + r2));
    let run = trace(&room, &plain(400_000), seed);
    let found = packets(run.deposited(0, 1).watts() / 0.8, &run);
    assert!(plausible(found, 400_000, factor, factor), "{found} of {}", factor * 400_000.0);
    assert_eq!(run.deposited(0, 0).watts(), 0.0, "from behind it passes");
}

/// A point inside thick glass: what leaves by one large face lies within the critical cone, and all else is kept inside.
#[test]
fn beyond_the_critical_angle_nothing_leaves() {
    let seed = seed_of("beyond_the_critical_angle_nothing_leaves");
    let lamp = PointSource::new(DVec3::Z, Flux::new(1.0)).unwrap();
    let block = Slab::new(square(1.0, 1e5, true), 1.0).unwrap();
    let n = 1.5;
    let room = room(Contents {
        lamps: vec![Lamp::Point(lamp)],
        glass: vec![Glass::new(GlassShape::Slab(block), n).unwrap()],
        receiver: screen(0.25, 1e6, true),
        ..Contents::default()
    });
    let run = trace(&room, &LightSettings { depth: 1, ..plain(400_000) }, seed);
    // ½ ∫ T sin i di up to the critical angle, in u = cos i = u₀ + (1 − u₀) z², which takes away T's root.
    let least = (1.0 - 1.0 / (n * n)).sqrt();
    let steps = 20_000;
    let sum: f64 = (0..steps)
        .map(|k| {
            let z = (f64::from(k) + 0.5) / f64::from(steps);
            let u = least + (1.0 - least) * z * z;
            let [rs, rp] = fresnel(1.0 / n, (1.0 - u * u).sqrt(), u);
            (1.0 - 0.5 * (rs + rp)) * 2.0 * z * (1.0 - least) / f64::from(steps)
        })
        .sum();
    let found = packets(run.deposited(0, 1).watts(), &run);
    assert!(plausible(found, 400_000, 0.5 * sum, 0.5 * sum), "{found} of {}", 0.5 * sum * 400_000.0);
    // What was reflected meets another face: terminated, and nothing else can be.
    let kept = packets(run.ledger.terminated, &run);
    assert!(plausible(kept, 400_000, 1.0 - sum, 1.0 - sum), "{kept}");
}

#[test]
fn beyond_the_depth_limit_light_is_booked_as_terminated() {
    let settings = |depth| LightSettings { depth, split: Split::Both, ..plain(10_000) };
    let contents = || Contents {
        lamps: vec![beam(DVec3::Z * 3.0, -DVec3::Z, 1e-6)],
        glass: vec![ball(1.0, 1.5)],
        receiver: screen(-2.0, 9.0, true),
        ..Contents::default()
    };
    // Straight through the middle: R = 0.04 at each face.
    let power = PI * 1e-12;
    for (depth, terminated, deposited) in
        [(0, 1.0, 0.0), (1, 0.96, 0.0), (2, 0.96 * 0.04, 0.96 * 0.96), (3, 0.96 * 0.0016, 0.96 * 0.96)]
    {
        let run = trace(&room(contents()), &settings(depth), 5);
        assert!((run.ledger.terminated / power - terminated).abs() < 1e-9, "{depth}: {:?}", run.ledger);
        assert!((run.ledger.deposited / power - deposited).abs() < 1e-9, "{depth}: {:?}", run.ledger);
        assert_sound("depth", &run);
    }
}

#[test]
fn paths_that_leave_their_plane_are_counted() {
    // Two slabs with crossed slants: the second has another plane of incidence.
    let tilted = |z: f64, u: DVec3, v: DVec3| {
        let middle = Rectangle::new(DVec3::Z * z, u * 9.0, v * 9.0).unwrap();
        Glass::new(GlassShape::Slab(Slab::new(middle, 0.1).unwrap()), 1.5).unwrap()
    };
    let slant = |a: f64, b: f64| {
        let n = DVec3::new(a, b, 1.0).normalize();
        let u = n.any_orthonormal_vector();
        (u, n.cross(u))
    };
    let ((u, v), (a, b)) = (slant(0.7, 0.0), slant(0.0, 0.7));
    let contents = |second: bool| {
        let mut glass = vec![tilted(8.0, u, v)];
        if second {
            glass.push(tilted(-8.0, a, b));
        }
        Contents {
            lamps: vec![beam(DVec3::Z * 20.0, -DVec3::Z, 0.5)],
            glass,
            receiver: screen(-20.0, 90.0, true),
            ..Contents::default()
        }
    };
    let one = trace(&room(contents(false)), &plain(5_000), 3);
    assert_eq!((one.depolarised, one.depolarised_flux), (0, 0.0));
    let two = trace(&room(contents(true)), &plain(5_000), 3);
    assert!(two.depolarised > 4_000 && two.depolarised_flux > 0.7 * two.ledger.emitted, "{}", two.depolarised);
    assert_sound("crossed plates", &two);
}

#[test]
fn an_enclosure_keeps_all_of_its_light() {
    let seed = seed_of("an_enclosure_keeps_all_of_its_light");
    let sphere = ReceiverShape::Sphere(Sphere::new(DVec3::ONE, 2.0).unwrap());
    let wall = DiffuseSurface::new(sphere, Albedo::new(0.5), Exitance::new(3.0), true).unwrap();
    let alone = room(Contents { diffuse: vec![wall.clone()], ..Contents::default() });
    let run = trace(&alone, &LightSettings { map: [8, 8], ..plain(200_000) }, seed);
    assert_sound("enclosure", &run);
    assert!((run.ledger.deposited / (3.0 * 16.0 * PI) - 1.0).abs() < 1e-12);
    // Evenly: each point receives what it sends.
    let map = &run.maps[0];
    for texel in map.grid().texels() {
        let share = map.area(texel) / (16.0 * PI);
        let found = packets(map.moments(texel, Light::Both).watts(), &run);
        // Sixty-four texels share the budget.
        assert!(
            plausible(found, 200_000, share * 0.999, share * 1.001),
            "{texel:?}: {found} of {}",
            share * 200_000.0
        );
    }
    // With a lamp inside, off the middle: all of its light too.
    let lamp = Lamp::Point(PointSource::new(DVec3::new(1.5, 1.0, 2.0), Flux::new(4.0)).unwrap());
    let lit = room(Contents { diffuse: vec![wall], lamps: vec![lamp], ..Contents::default() });
    let run = trace(&lit, &plain(10_000), seed);
    assert!((run.ledger.deposited / run.ledger.emitted - 1.0).abs() < 1e-12);
}

#[test]
fn what_no_light_reaches_is_told_and_divides_nothing() {
    let dark = room(Contents {
        lamps: vec![beam(DVec3::Z * 3.0, DVec3::Z, 0.5)],
        glass: vec![ball(1.0, 1.5)],
        receiver: screen(-2.0, 9.0, true),
        ..Contents::default()
    });
    let run = trace(&dark, &plain(1_000), 1);
    assert_eq!((run.reached.as_slice(), run.ledger.deposited), ([0].as_slice(), 0.0));
    assert_sound("away", &run);
    let off = Lamp::Point(PointSource::new(DVec3::Z * 3.0, Flux::new(0.0)).unwrap());
    let off = room(Contents {
        lamps: vec![off],
        glass: vec![ball(1.0, 1.5)],
        receiver: screen(-2.0, 9.0, true),
        ..Contents::default()
    });
    let run = trace(&off, &plain(1_000), 1);
    assert_eq!((run.ledger.rays, run.ledger.emitted, run.ledger.residual()), (0, 0.0, 0.0));
    assert_eq!(run.ledger.relative_residual(), 0.0);
    assert_eq!(run.maps[0].nearest(DVec3::Z * -2.0, Light::Both).watts_per_square_metre(), 0.0);
}

/// Direct light of a source on a triangle, with corrected texels: the irradiance of a texel is the source's form factor.
#[test]
fn a_triangle_and_a_globe_are_not_distorted() {
    let seed = seed_of("a_triangle_and_a_globe_are_not_distorted");
    let lamp = Lamp::Point(PointSource::new(DVec3::new(0.2, 0.1, 0.0), Flux::new(4.0 * PI)).unwrap());
    let slanted = [DVec3::new(-2.0, -1.0, 1.0), DVec3::new(0.5, 2.0, 1.0), DVec3::new(2.0, -1.5, 1.0)];
    let triangle = etendue::geometry::Triangle::new(slanted).unwrap();
    assert!(triangle.normal().z < 0.0, "it faces the lamp");
    let globe = Sphere::new(DVec3::new(0.0, 0.0, -4.0), 1.0).unwrap();
    let lands = |shape| DiffuseSurface::new(shape, Albedo::new(0.5), Exitance::new(0.0), false).unwrap();
    let shapes = [ReceiverShape::Triangle(triangle), ReceiverShape::Sphere(globe)];
    let contents = Contents { lamps: vec![lamp], diffuse: shapes.map(lands).to_vec(), ..Contents::default() };
    let rays = 2_000_000;
    let run = trace(&room(contents), &LightSettings { map: [6, 6], ..plain(rays) }, seed);
    for map in &run.maps {
        let mut lit = 0;
        for texel in map.grid().texels() {
            // The mean of cosθ/r² over the texel by points of it, weighed by the map's density.
            let [[s0, s1], [t0, t1]] = map.grid().extent(texel);
            let n = 24;
            let (mut sum, mut weight) = (0.0, 0.0);
            for i in 0..n {
                for j in 0..n {
                    let at = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n));
                    let at = [s0 + (s1 - s0) * at[0], t0 + (t1 - t0) * at[1]];
                    let point = map.parametrisation().to_surface(at);
                    let normal =
                        if map.parametrisation().wraps() { point - globe.center() } else { triangle.normal() };
                    let offset = DVec3::new(0.2, 0.1, 0.0) - point;
                    let density = map.parametrisation().density(at);
                    sum += density * (offset.dot(normal) / offset.length().powi(3)).max(0.0);
                    weight += density;
                }
            }
            let whole = map.parametrisation().map_triangle().is_none()
                || (map.area(texel) * 36.0 / (weight / f64::from(n * n)) - 1.0).abs() < 1e-9;
            if !whole || sum == 0.0 {
                continue;
            }
            lit += 1;
            let found = map.irradiance(texel, Light::Direct).unwrap().watts_per_square_metre();
            let expected = sum / weight;
            let spread = map.moments(texel, Light::Direct).std_error(map.n_groups()).unwrap() / map.area(texel);
            // The terminator cuts some texels: the lattice tells those to a part in a hundred.
            assert!((found - expected).abs() <= FAR * spread + 0.01 * expected, "{texel:?}: {found} {expected}");
        }
        assert!(lit >= 6, "{lit}");
    }
    assert_sound("triangle and globe", &run);
}

#[test]
fn threads_move_no_bit() {
    let case = shipped_caustics().find(|case| case.name() == "caustic/ball-on-a-globe").unwrap().read().unwrap();
    let settings = LightSettings { rays: 150_000, ..case.light.clone() };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trace(&case.configuration, &settings, 9))
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.ledger, three.ledger);
    let texels = |run: &LightRun| -> Vec<_> {
        run.maps[0].grid().texels().map(|texel| run.maps[0].moments(texel, Light::Both)).collect()
    };
    assert_eq!(texels(&one), texels(&three));
    assert_ne!(trace(&case.configuration, &settings, 10).ledger, one.ledger, "another seed is another run");
}

/// Occluders, sources and the backs of diffuse surfaces keep what they get.
#[test]
fn what_blocks_absorbs() {
    let down = || vec![beam(DVec3::Z * 3.0, -DVec3::Z, 0.5)];
    let cover = Shape::Disk(Disk::new(DVec3::Z, DVec3::Z, 1.0).unwrap());
    let corners = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(|[x, y]| DVec3::new(x, y, 1.0));
    let mesh = etendue::geometry::Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let black = DiffuseSurface::new(
        ReceiverShape::Rectangle(square(1.0, 9.0, false)),
        Albedo::new(0.5),
        Exitance::new(0.0),
        false,
    );
    let floor = || screen(0.0, 9.0, true);
    for contents in [
        Contents { lamps: down(), occluders: vec![cover], receiver: floor(), ..Contents::default() },
        Contents { lamps: down(), occluders: vec![Shape::Mesh(mesh)], receiver: floor(), ..Contents::default() },
        Contents { lamps: down(), diffuse: vec![black.unwrap()], receiver: floor(), ..Contents::default() },
    ] {
        let run = trace(&room(contents), &plain(2_000), 1);
        assert!((run.ledger.absorbed / run.ledger.emitted - 1.0).abs() < 1e-12, "{:?}", run.ledger);
    }
    let open = Contents { lamps: down(), receiver: floor(), ..Contents::default() };
    let run = trace(&room(open), &plain(2_000), 1);
    assert!((run.deposited(0, 0).watts() / run.ledger.emitted - 1.0).abs() < 1e-12);
}

/// Flat mirrors, whole spheres, slabs and diffuse surfaces stop direct light as occluders of their outline do, for the exact
/// side and for the estimator alike; a diffuse surface that emits is a source.
#[test]
fn optics_stop_direct_light_as_their_outlines_do() {
    use etendue::Oracle;
    use etendue::configuration::{Arrangement, MeasurementPoint};
    use etendue::estimator::{AreaEstimator, Estimator, Job, Scratch};
    use etendue::sampling::{Purpose, Strategy, StreamKey};

    let lamp =
        || Source::new(Shape::Disk(Disk::new(DVec3::Z * 3.0, -DVec3::Z, 0.6).unwrap()), Exitance::new(2.0)).unwrap();
    let points: Vec<_> =
        (0..9).map(|k| MeasurementPoint::new(DVec3::X * (0.2 * f64::from(k)), DVec3::Z).unwrap()).collect();
    let with = |contents: Contents| {
        let arrangement = Arrangement::Line;
        room(Contents { sources: vec![lamp()], points: points.clone(), arrangement, ..contents })
    };
    let disk = Disk::new(DVec3::Z, DVec3::Z, 0.4).unwrap();
    let sphere = Sphere::new(DVec3::Z * 1.5, 0.5).unwrap();
    let slab = Slab::new(square(1.0, 0.7, true), 0.3).unwrap();
    let black = |shape| DiffuseSurface::new(shape, Albedo::new(0.5), Exitance::new(0.0), false).unwrap();
    let occluders = |shapes: Vec<Shape>| with(Contents { occluders: shapes, ..Contents::default() });
    let mirror = Mirror::new(MirrorShape::Disk(disk), 0.9).unwrap();
    let glass = |shape| with(Contents { glass: vec![Glass::new(shape, 1.5).unwrap()], ..Contents::default() });
    let pairs = [
        (with(Contents { mirrors: vec![mirror], ..Contents::default() }), occluders(vec![Shape::Disk(disk)])),
        (glass(GlassShape::Sphere(sphere)), occluders(vec![Shape::Sphere(sphere)])),
        (glass(GlassShape::Slab(slab)), occluders(slab.faces().into_iter().map(Shape::Rectangle).collect())),
        (
            with(Contents { diffuse: vec![black(ReceiverShape::Disk(disk))], ..Contents::default() }),
            occluders(vec![Shape::Disk(disk)]),
        ),
    ];
    let estimates = |room: &Configuration| {
        let cell = StreamKey::cell(1, 2, Purpose::Measurement, Strategy::Random, 64);
        let job = Job { strategy: Strategy::Random, samples: 64, cell, replicates: 0..10, points: room.points() };
        let mut out = vec![f64::NAN; 90];
        AreaEstimator::new(room).estimate(&job, &mut Scratch::default(), &mut out);
        out
    };
    for (optic, occluder) in &pairs {
        assert_ne!(optic.digest(), occluder.digest());
        let exact = |room: &Configuration| {
            let oracle = Oracle::new(room);
            points.iter().map(|point| oracle.at(point).irradiance).collect::<Vec<_>>()
        };
        assert_eq!(exact(optic), exact(occluder));
        assert_eq!(estimates(optic), estimates(occluder));
    }
    let glowing =
        DiffuseSurface::new(ReceiverShape::Disk(disk), Albedo::new(0.5), Exitance::new(2.0), false).unwrap();
    let room = with(Contents { diffuse: vec![glowing], ..Contents::default() });
    assert_eq!((room.sources().len(), room.blockers().len()), (2, 0));
}
