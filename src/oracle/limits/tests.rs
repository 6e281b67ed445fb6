use super::*;
use crate::configuration::{Arrangement, Receiver, ReceiverShape, Source};
use crate::geometry::{Disk, Rectangle, Shape, Sphere};
use crate::radiometry::Exitance;
use proptest::prelude::*;

fn room(source: Shape, occluder: Shape, from: DVec3, to: DVec3, normal: DVec3) -> Option<Configuration> {
    let source = Source::new(source, Exitance::new(1.0)).ok()?;
    let points = [from, to].map(|at| crate::configuration::MeasurementPoint::new(at, normal));
    let points: Result<Vec<_>, _> = points.into_iter().collect();
    Configuration::new(vec![source], vec![occluder], None, points.ok()?, Arrangement::Line).ok()
}

/// A disk (normal along z) from a case's numbers.
fn disk(x: f64, y: f64, z: f64, radius: f64) -> Shape {
    Shape::Disk(Disk::new(DVec3::new(x, y, z), DVec3::NEG_Z, radius).unwrap())
}

fn names(limits: &[Limit]) -> Vec<&'static str> {
    limits.iter().map(Limit::name).collect()
}

/// Closed forms and bisection agree within their bounds, one for one, but for pairs closer than either's scan can see.
fn both_ways(configuration: &Configuration, widest_bound: f64) -> Result<usize, TestCaseError> {
    let path = Path::of(configuration).unwrap();
    let Some(closed) = closed::limits(configuration, &path) else {
        return Err(TestCaseError::reject("no closed form"));
    };
    // The scan's own limit: what begins and ends between two of its places.
    let stretch = path.length() / 1024.0;
    let ends = closed.iter().map(|limit| limit.distance).chain([0.0, path.length()]);
    let mut ends: Vec<f64> = ends.collect();
    ends.sort_by(f64::total_cmp);
    prop_assume!(ends.windows(2).all(|pair| pair[1] - pair[0] > stretch));
    let found = search::limits(configuration, &path);
    prop_assert_eq!(names(&closed), names(&found), "{:?}\n{:?}", closed, found);
    for (closed, found) in closed.iter().zip(&found) {
        let apart = (closed.distance - found.distance).abs();
        prop_assert!(apart <= closed.bound + found.bound, "{closed:?} against {found:?}: {apart:e}");
        prop_assert!(closed.bound < widest_bound, "{closed:?}");
    }
    Ok(closed.len())
}

/// Found by the law below: an occluder near its source, whose edges are seen from far off.
#[test]
fn a_shadow_thrown_far_is_bounded_for_its_lever() {
    let rectangle = |z: f64, u: f64, v: f64| {
        Shape::Rectangle(Rectangle::new(flat(0.0, 0.0, z), DVec3::X * (2.0 * u), DVec3::NEG_Y * (2.0 * v)).unwrap())
    };
    let (source, occluder) =
        (rectangle(2.0, 0.9239339295920097, 0.3530896918618513), rectangle(1.6194542801284812, 0.1, 0.1));
    let room = room(source, occluder, flat(-4.0, 0.0, 0.0), flat(5.0, 0.0, 0.0), DVec3::Z);
    both_ways(&room.unwrap(), 1e-10).unwrap();
}

fn flat(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn disks_in_closed_form_and_by_bisection(
        a in 0.1..1.0, b in 0.1..1.0, z in 0.3..1.7, x in -0.5..0.5, y in -0.5..0.5, slant in -1.0..1.0,
    ) {
        let room = room(disk(0.0, 0.0, 2.0, a), disk(x, y, z, b), flat(-4.0, slant, 0.0), flat(5.0, -slant, 0.0), DVec3::Z);
        both_ways(&room.unwrap(), 1e-5)?;
    }

    #[test]
    fn boxes_in_closed_form_and_by_bisection(
        a in (0.1..1.0, 0.1..1.0), b in (0.1..1.0, 0.1..1.0), z in 0.3..1.7, x in -0.5..0.5, slant in -1.0..1.0,
    ) {
        let rectangle = |x: f64, z: f64, (u, v): (f64, f64)| {
            let shape = Rectangle::new(flat(x, 0.0, z), DVec3::X * (2.0 * u), DVec3::NEG_Y * (2.0 * v));
            Shape::Rectangle(shape.unwrap())
        };
        let room =
            room(rectangle(0.0, 2.0, a), rectangle(x, z, b), flat(-4.0, slant, 0.0), flat(5.0, -slant, 0.0), DVec3::Z);
        both_ways(&room.unwrap(), 1e-10)?;
    }

    #[test]
    fn spheres_in_closed_form_and_by_bisection(
        a in 0.1..0.6, b in 0.1..0.6, x in -0.3..0.3, z in -1.5..0.7, slope in -0.8..0.8, y in -0.2..0.2,
    ) {
        let ball = |x: f64, z: f64, radius: f64| Shape::Sphere(Sphere::new(flat(x, 0.0, z), radius).unwrap());
        // Any line below them, even a steep one.
        let (from, to) = (flat(-2.0, y, -2.5 - slope), flat(2.0, -y, -2.5 + slope));
        let room = room(ball(0.0, 2.0, a), ball(x, z, b), from, to, DVec3::Z);
        both_ways(&room.unwrap(), 1e-5)?;
    }
}

/// The eclipse of the shipped case: umbra to 0.2 m, penumbra to 1.2 m.
#[test]
fn an_eclipse_has_two_limits() {
    let room = room(disk(0.0, 0.0, 2.0, 0.5), disk(0.0, 0.0, 1.0, 0.35), DVec3::ZERO, flat(1.5, 0.0, 0.0), DVec3::Z);
    let found = limits(&room.unwrap()).unwrap();
    assert_eq!(names(&found), ["umbra_ends", "penumbra_ends"]);
    for (limit, expected) in found.iter().zip([0.2, 1.2]) {
        assert!((limit.distance - expected).abs() <= limit.bound && limit.bound < 1e-13, "{limit:?}");
        assert_eq!(limit.method, LimitMethod::ClosedForm);
    }
}

/// A small disk before a large one leaves a ring, told by bisection too where the poses match no closed form.
#[test]
fn an_annular_eclipse_has_an_antumbra() {
    let tilted =
        |z: f64, radius: f64, normal: DVec3| Shape::Disk(Disk::new(flat(0.0, 0.0, z), normal, radius).unwrap());
    let (from, to) = (flat(-3.0, 0.0, 0.0), flat(3.0, 0.0, 0.0));
    let wanted = ["penumbra_begins", "antumbra_begins", "antumbra_ends", "penumbra_ends"];
    for source_tilt in [DVec3::NEG_Z, DVec3::new(0.1, 0.0, -1.0)] {
        let source = tilted(2.0, 1.0, source_tilt);
        let small = tilted(1.0, 0.2, source_tilt);
        let found = limits(&room(source, small, from, to, DVec3::Z).unwrap()).unwrap();
        assert_eq!(names(&found), wanted);
        let is_closed = found[0].method == LimitMethod::ClosedForm;
        assert_eq!(is_closed, source_tilt == DVec3::NEG_Z, "a tilted pair is parallel to no horizontal line");
    }
}

/// A straight edge before a disk: where the edge's shadow touches the disk, at x = ∓a when it hangs half way.
#[test]
fn a_half_plane_has_its_limits_by_bisection() {
    let plate = Rectangle::new(flat(-5.0, 0.0, 1.0), DVec3::X * 10.0, DVec3::Y * 20.0).unwrap();
    let source = disk(0.0, 0.0, 2.0, 0.5);
    let room = room(source, Shape::Rectangle(plate), flat(-0.9, 0.0, 0.0), flat(0.9, 0.0, 0.0), DVec3::Z).unwrap();
    let found = limits(&room).unwrap();
    assert_eq!(names(&found), ["umbra_ends", "penumbra_ends"]);
    for (limit, x) in found.iter().zip([-0.5, 0.5]) {
        assert!((limit.position.x - x).abs() <= limit.bound && limit.bound < 1e-12, "{limit:?}");
    }
}

/// A point on a turning ball sees the source rise and set.
#[test]
fn on_a_ball_the_source_sets() {
    let receiver = Receiver::new(ReceiverShape::Sphere(Sphere::new(DVec3::ZERO, 0.5).unwrap()), None).unwrap();
    let points = receiver.line(flat(0.0, 0.0, 0.5), flat(0.5, 0.0, 0.0), 5).unwrap();
    let source = Source::new(disk(0.0, 0.0, 3.0, 0.2), Exitance::new(1.0)).unwrap();
    let room = Configuration::new(vec![source], vec![], Some(receiver), points, Arrangement::Line).unwrap();
    let found = limits(&room).unwrap();
    assert_eq!(names(&found), ["penumbra_begins", "source_sets"]);
    // The disk's near and far rim touch the horizon of the place at the angle φ where 3 cos φ ± 0.2 sin φ = 0.5.
    for (limit, side) in found.iter().zip([-1.0, 1.0]) {
        let angle = limit.distance / 0.5;
        let height = 3.0 * angle.cos() + side * 0.2 * angle.sin() - 0.5;
        assert!(height.abs() < 1e-12, "{limit:?}: {height:e}");
    }
}

#[test]
fn what_is_no_line_has_no_limits() {
    let point = |x: f64| crate::configuration::MeasurementPoint::new(flat(x, 0.0, 0.0), DVec3::Z).unwrap();
    let room = |points: Vec<_>, arrangement| {
        let source = Source::new(disk(0.0, 0.0, 2.0, 0.5), Exitance::new(1.0)).unwrap();
        Configuration::new(vec![source], vec![], None, points, arrangement).unwrap()
    };
    assert_eq!(limits(&room(vec![point(0.0)], Arrangement::Line)), Err(NoPath::NoLength));
    assert_eq!(limits(&room(vec![point(0.0), point(1.0)], Arrangement::Scattered)), Err(NoPath::NotALine));
    assert_eq!(limits(&room(vec![point(0.0), point(1.0)], Arrangement::Line)), Ok(vec![]));
}
