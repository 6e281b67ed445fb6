//! Statements of radiometry as every lecture makes them, checked with numbers.

use std::f64::consts::PI;

use approx::{assert_relative_eq, relative_eq};
use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Polygon, Rectangle, Shape, Sphere, solid_angle};
use etendue::oracle::{Oracle, patch};
use etendue::radiometry::{
    Albedo, Area, Exitance, Flux, FormFactor, Intensity, Irradiance, PointSource, ProjectedSolidAngle, Radiosity,
    SolidAngle,
};

use crate::closed_forms::Table;
use crate::icosphere::icosphere;

fn irradiance(source: Shape, exitance: Exitance, at: DVec3, normal: DVec3) -> Irradiance {
    let point = MeasurementPoint::new(at, normal).unwrap();
    let source = Source::new(source, exitance).unwrap();
    let room = Configuration::new(vec![source], vec![], None, vec![point], Arrangement::Scattered).unwrap();
    Oracle::new(&room).at(&point).irradiance
}

/// From the middle of a cube each face fills a sixth of all directions, so that 4π I is what I Ω adds up to; from anywhere
/// else inside the faces differ, and the sum does not.
#[test]
fn a_closed_surface_receives_all_of_a_point_source() {
    let lamp = |at: DVec3| PointSource::new(at, Flux::new(60.0)).unwrap();
    for at in [DVec3::ZERO, DVec3::new(0.3, -0.4, 0.2), DVec3::new(0.4999, 0.4999, -0.4999)] {
        let faces = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]).map(|axis| {
            let u = axis.any_orthonormal_vector();
            Rectangle::new(axis * 0.5, u, axis.cross(u)).unwrap()
        });
        let into = |face: Rectangle| lamp(at).flux_into(SolidAngle::new(solid_angle::rectangle(at, &face).unwrap()));
        let fluxes: Vec<Flux> = faces.map(into).collect();
        if at == DVec3::ZERO {
            for flux in &fluxes {
                assert_relative_eq!(flux.watts(), 10.0, max_relative = 1e-14);
            }
        }
        assert_relative_eq!(fluxes.into_iter().sum::<Flux>().watts(), 60.0, max_relative = 1e-13);
    }
}

#[test]
fn the_faces_of_an_icosphere_fill_all_directions() {
    let intensity = Intensity::new(3.0);
    for eye in [DVec3::ZERO, DVec3::new(0.2, 0.5, -0.3)] {
        for levels in [0, 2, 4] {
            let ball = icosphere(levels);
            let into = |face: &[u32; 3]| {
                let corners = face.map(|i| ball.vertices()[i as usize]);
                intensity * SolidAngle::new(solid_angle::triangle(eye, corners).unwrap())
            };
            let sum: Flux = ball.triangles().iter().map(into).sum();
            assert_relative_eq!(sum.watts(), 3.0 * 4.0 * PI, max_relative = 1e-13);
        }
    }
}

/// Why a point source has no brightness. Its flux through every sphere around it is the same, since irradiance falls with
/// the square of the distance. Were it a surface of some radiosity, "as bright" from near and far, spheres of radius R and r
/// would receive in the ratio (R/r)²: power out of nothing.
#[test]
fn a_point_source_has_an_intensity_but_no_brightness() {
    let lamp = PointSource::new(DVec3::ZERO, Flux::new(100.0)).unwrap();
    let sphere = |radius: f64| Sphere::new(lamp.position(), radius).unwrap();
    let through = |radius: f64| {
        // Irradiance at a place of the sphere, which is the same all over it, times its area.
        let place = lamp.position() + DVec3::new(2.0, -1.0, 2.0) / 3.0 * radius;
        lamp.irradiance_at(place, lamp.position() - place).unwrap() * Area::new(sphere(radius).area())
    };
    for radius in [1e-6, 0.5, 1.0, 2.0, 1e6] {
        assert_relative_eq!(through(radius).watts(), 100.0, max_relative = 1e-14);
        let inside = SolidAngle::new(solid_angle::sphere(lamp.position(), &sphere(radius)).unwrap());
        assert_relative_eq!(lamp.flux_into(inside).watts(), 100.0, max_relative = 1e-15);
    }
    // The wrong reading: an irradiance that does not know the distance.
    let brightness = Irradiance::new(8.0);
    let wrong = |radius: f64| brightness * Area::new(sphere(radius).area());
    let (far, near) = (wrong(3.0).watts(), wrong(0.5).watts());
    assert_relative_eq!(far / near, 36.0, max_relative = 1e-14);
    assert!(!relative_eq!(far, near, max_relative = 0.5), "else nothing would speak against it");
    // And the right one: what is seen of a glowing ball shrinks with the square, its radiance does not.
    let ball = |distance: f64| {
        let shape = Shape::Sphere(Sphere::new(DVec3::Z * distance, 0.01).unwrap());
        irradiance(shape, Exitance::new(8.0), DVec3::ZERO, DVec3::Z).watts_per_square_metre()
    };
    assert_relative_eq!(ball(1.0) / ball(7.0), 49.0, max_relative = 1e-13);
    let seen = |distance: f64| {
        let filled = Sphere::new(DVec3::Z * distance, 0.01).unwrap();
        ball(distance) / solid_angle::sphere(DVec3::ZERO, &filled).unwrap()
    };
    // Irradiance over solid angle tends to the radiance M/π, from near and far.
    assert_relative_eq!(seen(1.0), 8.0 / PI, max_relative = 1e-4);
    assert_relative_eq!(seen(7.0), 8.0 / PI, max_relative = 1e-6);
}

/// A lamp so small that it is a point: a ball of power P has the point source's irradiance, exactly so where it is wholly
/// above the horizon.
#[test]
fn a_small_ball_is_a_point_source() {
    for radius in [0.1, 1e-3, 1e-6] {
        let ball = Sphere::new(DVec3::new(0.3, -0.2, 1.0), radius).unwrap();
        let power = Flux::new(5.0);
        let exitance = Exitance::mean_of(power, Area::new(ball.area()));
        let lamp = PointSource::new(ball.center(), power).unwrap();
        let (at, normal) = (DVec3::ZERO, DVec3::new(0.1, 0.0, 1.0));
        assert_relative_eq!(
            irradiance(Shape::Sphere(ball), exitance, at, normal).watts_per_square_metre(),
            lamp.irradiance_at(at, normal).unwrap().watts_per_square_metre(),
            max_relative = 1e-14
        );
    }
}

/// The power from a patch S to a patch T can be told from either end: M A_S F_ST = M A_T F_TS.
#[test]
fn power_from_patch_to_patch_is_told_from_either_end() {
    let exitance = Exitance::new(12.0);
    let power = |area: f64, factor: FormFactor| (exitance * factor) * Area::new(area);
    let told = |area_s: f64, st: FormFactor, area_t: f64, ts: FormFactor| {
        // Leaving S and bound for T; and arriving at T, whose mean irradiance is M F_TS.
        let (leaving, arriving) = (power(area_s, st), power(area_t, ts));
        assert_relative_eq!(leaving.watts(), arriving.watts(), max_relative = 1e-14);
        leaving.watts()
    };
    let disks = |from: f64, to: f64| patch::disk_to_disk(from, to, 0.7).unwrap();
    let area = |radius: f64| PI * radius * radius;
    told(area(0.4), disks(0.4, 1.5), area(1.5), disks(1.5, 0.4));
    let walls = |from: f64, to: f64| patch::rectangle_to_adjoining_rectangle(from, to, 2.0).unwrap();
    told(0.3 * 2.0, walls(0.3, 5.0), 5.0 * 2.0, walls(5.0, 0.3));
    // With numbers: two facing unit squares one metre apart exchange a fifth of what leaves them.
    let squares = patch::rectangle_to_opposite_rectangle(1.0, 1.0, 1.0).unwrap();
    assert_relative_eq!(told(1.0, squares, 1.0, squares), 12.0 * 0.199_824_895_698_387_38, max_relative = 1e-14);
}

/// Three targets T1, T2, T3 at different distances and slants that have the same outline seen from S receive the same power
/// from S: what an element sends into a cone of directions does not depend on where it is caught.
#[test]
fn targets_with_the_same_outline_receive_the_same_power() {
    let table = Table::read("foreshortening");
    let mut groups: Vec<(String, Vec<(f64, DVec3)>)> = Vec::new();
    for row in table.rows() {
        let text = row.text("source");
        let numbers: Vec<f64> = text.split_whitespace().skip(2).map(|word| word.parse().unwrap()).collect();
        let target = Polygon::new(numbers.chunks(3).map(DVec3::from_slice).collect()).unwrap();
        let heights = DVec3::from_slice(&target.vertices().iter().map(|vertex| vertex.z).collect::<Vec<_>>());
        // The table's receiving element is S here: by reciprocity the same factor tells what S sends to the target.
        let normal = DVec3::new(row.number("nx"), row.number("ny"), row.number("nz"));
        let share = irradiance(Shape::Polygon(target), Exitance::new(1.0), DVec3::ZERO, normal);
        let share = FormFactor::new(share.watts_per_square_metre());
        assert_relative_eq!(share.ratio(), row.number("F"), max_relative = 1e-12);
        let power = (Exitance::new(40.0) * share) * Area::new(1e-4);
        match groups.iter_mut().find(|(name, _)| name == row.text("case")) {
            Some((_, targets)) => targets.push((power.watts(), heights)),
            None => groups.push((row.text("case").to_owned(), vec![(power.watts(), heights)])),
        }
    }
    assert_eq!(groups.len(), 10);
    for (name, targets) in groups {
        let [(first, heights), rest @ ..] = &targets[..] else { panic!("{name} is empty") };
        assert_eq!(rest.len(), 2, "{name}");
        for (power, other) in rest {
            assert_relative_eq!(power, first, max_relative = 1e-12);
            let apart = (*other / *heights - 1.0).abs().max_element();
            assert!(apart > 0.05, "{name}: one target thrice would prove nothing");
        }
    }
}

/// Exitance, irradiance, radiosity, radiance and flux, there and back.
#[test]
fn quantities_survive_their_round_trips() {
    let area = Area::new(2.5);
    let emitted = Exitance::new(300.0);
    assert_eq!(Exitance::mean_of(emitted * area, area), emitted);
    let arriving = Irradiance::new(40.0);
    assert_eq!(Irradiance::mean_of(arriving * area, area), arriving);
    let leaving: Radiosity = arriving * Albedo::new(0.5) + emitted;
    assert_eq!(leaving.watts_per_square_metre(), 320.0);
    assert_eq!(Radiosity::mean_of(leaving * area, area), leaving);
    let again = Radiosity::of_radiance(leaving.radiance());
    assert_relative_eq!(again.watts_per_square_metre(), 320.0, max_relative = 1e-15);
    // All that a diffuse surface sends out, summed over the hemisphere, is its exitance: L π = M.
    let hemisphere = ProjectedSolidAngle::from(FormFactor::new(1.0));
    assert_relative_eq!((emitted.radiance() * hemisphere).watts_per_square_metre(), 300.0, max_relative = 1e-15);
}

/// Irradiance is radiance times projected solid angle: the exact side's form factors are π times smaller, and for a far
/// source it is the solid angle times the cosine.
#[test]
fn irradiance_is_radiance_times_projected_solid_angle() {
    let round = Disk::new(DVec3::new(30.0, 0.0, 40.0), DVec3::new(-3.0, 0.0, -4.0), 0.05).unwrap();
    let exitance = Exitance::new(7.0);
    let found = irradiance(Shape::Disk(round), exitance, DVec3::ZERO, DVec3::Z);
    let omega = solid_angle::disk(DVec3::ZERO, &round).unwrap();
    let projected = ProjectedSolidAngle::new(omega * 0.8);
    let expected = exitance.radiance() * projected;
    assert_relative_eq!(
        found.watts_per_square_metre(),
        expected.watts_per_square_metre(),
        // (size / distance)²
        max_relative = 1e-6
    );
}
