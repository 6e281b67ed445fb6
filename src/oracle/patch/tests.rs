use super::*;
use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use crate::geometry::{DVec3, Disk, Polygon, Rectangle, Shape, Triangle};
use crate::oracle::Oracle;
use crate::radiometry::Exitance;

fn rectangle(center: [f64; 3], u: DVec3, v: DVec3) -> Rectangle {
    Rectangle::new(DVec3::from(center), u, v).unwrap()
}

fn factor(from: &Patch, to: &Patch, occluders: &[Shape], relative: f64) -> PatchFactor {
    let found = patch_to_patch(from, to, occluders, Tolerance::relative(relative)).unwrap();
    println!("{:.15} ± {:.1e} after {}", found.form_factor.ratio(), found.bound, found.evaluations);
    found
}

/// Within its own bound of what is known, and a bound no wider than a few times what was asked for.
fn expect(found: PatchFactor, known: f64, relative: f64) {
    let off = (found.form_factor.ratio() - known).abs();
    assert!(off <= found.bound + 4.0 * f64::EPSILON * known, "{found:?}: {known}, off {off:e}");
    assert!(found.bound <= 2.0 * relative * known, "{found:?}: asked for {relative:e}");
}

#[test]
fn disks_are_the_average_of_their_points() {
    let disk = |z: f64, up: f64, radius: f64| Patch::Disk(Disk::new(DVec3::Z * z, DVec3::Z * up, radius).unwrap());
    for (r1, r2, gap) in [(1.0, 1.0, 1.0), (0.3, 2.0, 0.5), (2.0, 0.1, 0.3)] {
        let known = disk_to_disk(r1, r2, gap).unwrap().ratio();
        for relative in [1e-6, 1e-10] {
            expect(factor(&disk(0.0, 1.0, r1), &disk(gap, -1.0, r2), &[], relative), known, relative);
        }
    }
}

#[test]
fn rectangles_are_the_average_of_their_points() {
    let floor = Patch::Rectangle(rectangle([1.0, 1.5, 0.0], DVec3::X * 2.0, DVec3::Y * 3.0));
    let ceiling = Patch::Rectangle(rectangle([1.0, 1.5, 1.0], DVec3::Y * 3.0, DVec3::X * 2.0));
    let wall = Patch::Rectangle(rectangle([0.0, 1.5, 0.5], DVec3::Y * 3.0, DVec3::Z));
    let opposite = rectangle_to_opposite_rectangle(2.0, 3.0, 1.0).unwrap().ratio();
    let adjoining = rectangle_to_adjoining_rectangle(2.0, 1.0, 3.0).unwrap().ratio();
    for relative in [1e-6, 1e-10] {
        expect(factor(&floor, &ceiling, &[], relative), opposite, relative);
        expect(factor(&floor, &wall, &[], relative), adjoining, relative);
    }
}

/// Two triangles, or an L and the square that it lacks, send what the whole rectangle sends.
#[test]
fn a_patch_sends_what_its_parts_send() {
    let ceiling = Patch::Rectangle(rectangle([0.3, 0.2, 1.0], DVec3::Y, DVec3::X));
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let whole = Patch::Rectangle(rectangle([1.0, 1.0, 0.0], DVec3::X * 2.0, DVec3::Y * 2.0));
    let halves = [[at(0.0, 0.0), at(2.0, 0.0), at(2.0, 2.0)], [at(0.0, 0.0), at(2.0, 2.0), at(0.0, 2.0)]];
    let halves = halves.map(|corners| Patch::Triangle(Triangle::new(corners).unwrap()));
    let l = [at(0.0, 0.0), at(2.0, 0.0), at(2.0, 1.0), at(1.0, 1.0), at(1.0, 2.0), at(0.0, 2.0)];
    let l = Patch::Polygon(Polygon::new(l.to_vec()).unwrap());
    let square = Patch::Rectangle(rectangle([1.5, 1.5, 0.0], DVec3::X, DVec3::Y));
    let occluder = Shape::Disk(Disk::new(DVec3::new(0.8, 0.7, 0.5), DVec3::Z, 0.2).unwrap());
    for occluders in [&[][..], std::slice::from_ref(&occluder)] {
        let sent = |patch: &Patch| {
            let found = factor(patch, &ceiling, occluders, 1e-5);
            (found.form_factor.ratio() * patch.area(), found.bound * patch.area())
        };
        let (known, bound) = sent(&whole);
        for parts in [&halves, &[l.clone(), square.clone()]] {
            let sums = parts.iter().map(sent).fold((0.0, bound), |sum, part| (sum.0 + part.0, sum.1 + part.1));
            assert!((sums.0 - known).abs() <= sums.1, "{sums:?} {known}");
        }
    }
}

/// What leaves by area arrives by area, with something in between too.
#[test]
fn obstructed_exchange_is_the_same_both_ways() {
    let low = Patch::Rectangle(rectangle([0.0, 0.0, 0.0], DVec3::X, DVec3::Y));
    let high = Patch::Disk(Disk::new(DVec3::new(0.4, 0.0, 1.0), DVec3::new(-0.2, 0.0, -1.0), 0.6).unwrap());
    let plate = Shape::Rectangle(rectangle([0.2, 0.1, 0.5], DVec3::X * 0.4, DVec3::Y * 0.3));
    let ball = Shape::Sphere(crate::geometry::Sphere::new(DVec3::new(-0.2, 0.2, 0.4), 0.15).unwrap());
    for occluders in [vec![plate.clone()], vec![ball.clone()], vec![plate, ball]] {
        let relative = 1e-4;
        let (there, back) = (factor(&low, &high, &occluders, relative), factor(&high, &low, &occluders, relative));
        let (there, back) = (
            (there.form_factor.ratio() * low.area(), there.bound * low.area()),
            (back.form_factor.ratio() * high.area(), back.bound * high.area()),
        );
        assert!((there.0 - back.0).abs() <= there.1 + back.1, "{there:?} {back:?}");
        assert!(there.1 + back.1 <= 8.0 * relative * there.0, "{there:?} {back:?}");
    }
}

/// An L-shaped room, 3 m high: the square 3 × 3 less its corner [1, 3] × [1, 3]. The two 3 × 3 walls that meet in the outer
/// corner see each other past the re-entrant edge, along 1/x + 1/y ≥ 1 in plan. The integrals over both heights and over one
/// of the lengths have closed forms, which leaves
///
/// ```text
/// 9 π F = ∫₀³ y h [G(√(X(y)² + y²)) − G(y)] dy,   X(y) = 3 for y ≤ 3/2, else y/(y − 1),   h = 3,
/// G(ρ) = −atan(h/ρ)/ρ − ln(ρ/√(ρ² + h²))/h
/// ```
///
/// to 40 digits 0.1823559036685957993192280911803579048495; unobstructed it is two faces of a cube, 0.2000437760754031.
#[test]
fn two_walls_past_a_re_entrant_edge() {
    const KNOWN: f64 = 0.182_355_903_668_595_8;
    let g = |rho: f64| -(3.0 / rho).atan() / rho - (rho / rho.hypot(3.0)).ln() / 3.0;
    let piece = |from: f64, to: f64, ends: [bool; 2]| {
        let f = |y: f64| {
            let x = if y <= 1.5 { 3.0 } else { y / (y - 1.0) };
            adaptive::Node { value: y * 3.0 * (g(x.hypot(y)) - g(y)), error: 0.0, kind: () }
        };
        let spec = adaptive::Spec { density: 1e-14, floor: 1e-16, resolution: 1e-9, blur: 0.0 };
        adaptive::integrate(f, [from, to], ends, &[], spec, || false).value
    };
    let by_one_integral =
        (piece(0.0, 1.5, [true, false]) + piece(1.5, 3.0, [false; 2])) / (9.0 * std::f64::consts::PI);
    approx::assert_relative_eq!(by_one_integral, KNOWN, max_relative = 1e-13);

    let west = Patch::Rectangle(rectangle([0.0, 1.5, 1.5], DVec3::Y * 3.0, DVec3::Z * 3.0));
    let south = Patch::Rectangle(rectangle([1.5, 0.0, 1.5], DVec3::Z * 3.0, DVec3::X * 3.0));
    // The walls of the corner that is missing.
    let faces_south = Shape::Rectangle(rectangle([2.0, 1.0, 1.5], DVec3::X * 2.0, DVec3::Z * 3.0));
    let faces_west = Shape::Rectangle(rectangle([1.0, 2.0, 1.5], DVec3::Y * 2.0, DVec3::Z * 3.0));
    let room = [faces_south, faces_west];
    for (relative, occluders) in [(1e-6, &room[..]), (1e-9, &room[..]), (1e-5, &room[..1])] {
        expect(factor(&west, &south, occluders, relative), KNOWN, relative);
    }
    expect(factor(&south, &west, &room, 1e-5), KNOWN, 1e-5);
    expect(factor(&west, &south, &[], 1e-6), 0.200_043_776_075_403_15, 1e-6);
}

/// Pixels across an eclipse: coarse answers within their bounds of fine ones, and cheap.
#[test]
fn pixels_across_a_shadow() {
    let disk = |z: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * z, DVec3::NEG_Z, radius).unwrap());
    let source = Source::new(disk(2.0, 0.5), Exitance::new(1.0)).unwrap();
    let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
    let room = Configuration::new(vec![source], vec![disk(1.0, 0.35)], None, vec![point], Arrangement::Scattered);
    let oracle = Oracle::new(&room.unwrap());
    let mut spent = 0;
    let pixels = 24;
    for i in 0..pixels {
        let size = 1.5 / f64::from(pixels);
        let pixel = rectangle([(f64::from(i) + 0.5) * size, 0.02, 0.0], DVec3::X * size, DVec3::Y * size);
        let pixel = Patch::Rectangle(pixel);
        let coarse = average_irradiance(&oracle, &pixel, Tolerance { absolute: 1e-9, ..Tolerance::relative(1e-6) });
        let fine = average_irradiance(&oracle, &pixel, Tolerance { absolute: 1e-13, ..Tolerance::relative(1e-10) });
        let number = |irradiance: crate::radiometry::Irradiance| irradiance.watts_per_square_metre();
        let off = (number(coarse.irradiance) - number(fine.irradiance)).abs();
        println!(
            "{i}: {:.12} off {off:.1e} bound {:.1e} ({}) fine {:.1e} ({})",
            number(fine.irradiance),
            number(coarse.bound),
            coarse.evaluations,
            number(fine.bound),
            fine.evaluations
        );
        assert!(off <= number(coarse.bound) + number(fine.bound), "{coarse:?} {fine:?}");
        assert!(number(coarse.bound) <= 1e-9 + 2e-6 * number(fine.irradiance), "{coarse:?}");
        assert!(number(fine.bound) <= 1e-12 + 2e-10 * number(fine.irradiance), "{fine:?}");
        spent += coarse.evaluations;
    }
    assert!(spent < 2000 * u64::from(pixels as u32), "{spent} evaluations");
}

#[test]
fn an_empty_budget_is_told_by_the_bound() {
    let low = Patch::Rectangle(rectangle([0.0, 0.0, 0.0], DVec3::X, DVec3::Y));
    let high = Patch::Rectangle(rectangle([0.0, 0.0, 1.0], DVec3::Y, DVec3::X));
    let plate = Shape::Rectangle(rectangle([0.2, 0.1, 0.5], DVec3::X * 0.4, DVec3::Y * 0.3));
    let tight = Tolerance { most_evaluations: 3000, ..Tolerance::relative(1e-12) };
    let found = patch_to_patch(&low, &high, std::slice::from_ref(&plate), tight).unwrap();
    let known = factor(&low, &high, &[plate], 1e-6);
    assert!(found.evaluations < 20_000, "{found:?}");
    assert!((found.form_factor.ratio() - known.form_factor.ratio()).abs() <= found.bound + known.bound);
    assert!(found.bound > 1e-11, "{found:?}");
}
