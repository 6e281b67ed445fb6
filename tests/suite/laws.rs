//! Laws that hold for every configuration, whatever its numbers.

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Frame, Mesh, Polygon, Rectangle, Shape, Sphere};
use etendue::oracle::{Method, Oracle, Region, Truth};
use etendue::radiometry::Exitance;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::gauss::Gauss;

/// A shape as numbers, so that it can be moved, turned and scaled.
#[derive(Clone, Debug)]
struct Figure {
    kind: u8,
    center: DVec3,
    axis: DVec3,
    a: f64,
    b: f64,
}

impl Figure {
    fn shape(&self) -> Shape {
        let frame = Frame::around(self.axis.normalize());
        self.with_frame(frame.tangent, frame.bitangent)
    }

    /// - `u`, `v`: perpendicular unit vectors in the figure's plane
    fn with_frame(&self, u: DVec3, v: DVec3) -> Shape {
        let Figure { kind, center, a, b, .. } = *self;
        match kind {
            0 => Shape::Disk(Disk::new(center, u.cross(v), a).unwrap()),
            1 => Shape::Rectangle(Rectangle::new(center, u * (2.0 * a), v * (2.0 * b)).unwrap()),
            2 => Shape::Sphere(Sphere::new(center, 0.6 * a).unwrap()),
            _ => {
                let corners = [u * a, v * b - u * a, -u * (0.3 * a), -v * b - u * a];
                Shape::Polygon(Polygon::new(corners.iter().map(|c| center + *c).collect()).unwrap())
            }
        }
    }

    fn moved(&self, motion: impl Fn(DVec3) -> DVec3, turn: impl Fn(DVec3) -> DVec3, scale: f64) -> Shape {
        let frame = Frame::around(self.axis.normalize());
        Figure { center: motion(self.center), a: self.a * scale, b: self.b * scale, ..self.clone() }
            .with_frame(turn(frame.tangent), turn(frame.bitangent))
    }
}

fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
    let x = move || -reach..reach;
    (x(), x(), x()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn figure(level: f64) -> impl Strategy<Value = Figure> {
    let axis = vector(1.0).prop_filter("a direction", |v| v.length() > 0.05);
    (0..4u8, vector(0.7), axis, 0.1..0.8, 0.1..0.8).prop_map(move |(kind, center, axis, a, b)| Figure {
        kind,
        center: center + DVec3::Z * level,
        axis,
        a,
        b,
    })
}

/// Turned towards the origin, so that most examples have light.
fn source() -> impl Strategy<Value = Figure> {
    figure(3.0).prop_map(|f| Figure { axis: if f.axis.dot(f.center) > 0.0 { -f.axis } else { f.axis }, ..f })
}

fn normal() -> impl Strategy<Value = DVec3> {
    vector(0.6).prop_map(|v| v + DVec3::Z)
}

fn truth(sources: &[Shape], occluders: &[Shape], position: DVec3, normal: DVec3) -> Truth {
    let sources = sources.iter().map(|s| Source::new(s.clone(), Exitance::new(1.0)).unwrap()).collect();
    let point = MeasurementPoint::new(position, normal).unwrap();
    let configuration =
        Configuration::new(sources, occluders.to_vec(), None, vec![point], Arrangement::Scattered).unwrap();
    Oracle::new(&configuration).at(&point)
}

fn factor(truth: &Truth) -> f64 {
    truth.form_factor.ratio()
}

fn bound(truth: &Truth) -> f64 {
    truth.bound.watts_per_square_metre()
}

fn shapes(figures: &[Figure]) -> Vec<Shape> {
    figures.iter().map(Figure::shape).collect()
}

/// A turn about a direction, by Rodrigues' formula.
fn turned(v: DVec3, axis: DVec3, angle: f64) -> DVec3 {
    v * angle.cos() + axis.cross(v) * angle.sin() + axis * (axis.dot(v) * (1.0 - angle.cos()))
}

/// Found by a law below: the second disk hides the ball; with the first one there again, whose outlines lie on one another,
/// it could not be told.
#[test]
fn what_one_occluder_hides_stays_hidden() {
    let disk = |x, y, normal, radius| Shape::Disk(Disk::new(DVec3::new(x, y, 1.5), normal, radius).unwrap());
    let ball = |x, y, z, radius| Shape::Sphere(Sphere::new(DVec3::new(x, y, z), radius).unwrap());
    let source = ball(-0.355429306964918, 0.6091288341536164, 3.0, 0.3937309199784325);
    let beside = disk(0.0, -0.5186617817424766, DVec3::NEG_Z, 0.7832386362728633);
    let hiding = disk(-0.082252946122132, 0.35739283027189045, DVec3::Z, 0.44105616331802994);
    let before = ball(-0.31534939754313446, -0.012697991855775517, 1.1014195591642444, 0.21046724229494726);
    let all = [beside.clone(), hiding, before, beside];
    for few in 2..=4 {
        let t = truth(std::slice::from_ref(&source), &all[..few], DVec3::ZERO, DVec3::Z);
        assert_eq!((factor(&t), bound(&t), t.region), (0.0, 0.0, Region::Umbra), "{few} occluders");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_form_factor_lies_between_nothing_and_the_unoccluded_one(
        source in source(), occluders in vec(figure(1.5), 0..4), n in normal(),
    ) {
        let t = truth(&[source.shape()], &shapes(&occluders), DVec3::ZERO, n);
        let open = t.unoccluded_irradiance.watts_per_square_metre();
        prop_assert!(0.0 <= factor(&t) && factor(&t) <= open && open <= 1.0, "{t:?}");
        let dark = matches!(t.region, Region::Umbra | Region::BelowHorizon);
        prop_assert_eq!(dark, factor(&t) == 0.0, "{:?}", t);
        let usable = if t.method == Method::ClosedForm { 1e-11 } else { 1e-8 };
        prop_assert!(bound(&t) < usable && (!dark || bound(&t) == 0.0), "{t:?}");
        prop_assert!(t.region != Region::Lit || factor(&t) == open, "{t:?}");
    }

    #[test]
    fn another_occluder_never_brightens(
        source in source(), occluders in vec(figure(1.5), 0..4), another in figure(1.5), n in normal(),
    ) {
        let mut all = shapes(&occluders);
        let before = truth(&[source.shape()], &all, DVec3::ZERO, n);
        all.push(another.shape());
        let after = truth(&[source.shape()], &all, DVec3::ZERO, n);
        prop_assert!(factor(&after) <= factor(&before) + bound(&before) + bound(&after), "{before:?}\n{after:?}");
    }

    #[test]
    fn the_same_occluder_twice_is_one(
        source in source(), occluders in vec(figure(1.5), 1..4), n in normal(),
    ) {
        let once = shapes(&occluders);
        let twice = [once.clone(), once.clone()].concat();
        let (a, b) = (truth(&[source.shape()], &once, DVec3::ZERO, n), truth(&[source.shape()], &twice, DVec3::ZERO, n));
        prop_assert!((factor(&a) - factor(&b)).abs() <= bound(&a) + bound(&b), "{a:?}\n{b:?}");
        prop_assert_eq!(a.region, b.region);
    }

    #[test]
    fn size_does_not_matter(
        source in source(), occluders in vec(figure(1.5), 0..4), n in normal(), power in -30..30, stretch in 1.0..2.0,
    ) {
        let a = truth(&[source.shape()], &shapes(&occluders), DVec3::ZERO, n);
        let scale = 10f64.powi(power) * stretch;
        let moved = |f: &Figure| f.moved(|p| p * scale, |v| v, scale);
        let b = truth(&[moved(&source)], &occluders.iter().map(moved).collect::<Vec<_>>(), DVec3::ZERO, n);
        // Scaling rounds every coordinate to its last bit; values are exact for their inputs, and feel that in proportion.
        prop_assert!((factor(&a) - factor(&b)).abs() <= 1e-14 + 2.0 * (bound(&a) + bound(&b)), "{a:?}\n{b:?}");
    }

    #[test]
    fn place_and_direction_do_not_matter(
        source in source(), occluders in vec(figure(1.5), 0..4), n in normal(),
        shift in vector(10.0), axis in vector(1.0).prop_filter("a direction", |v| v.length() > 0.05), angle in 0.0..6.3,
    ) {
        let axis = axis.normalize();
        let a = truth(&[source.shape()], &shapes(&occluders), DVec3::ZERO, n);
        let moved = |f: &Figure| f.moved(|p| turned(p, axis, angle) + shift, |v| turned(v, axis, angle), 1.0);
        let b = truth(
            &[moved(&source)], &occluders.iter().map(moved).collect::<Vec<_>>(), shift, turned(n, axis, angle),
        );
        // A motion rounds every coordinate to a few ulp of 10 m; a form factor feels that about in proportion.
        prop_assert!((factor(&a) - factor(&b)).abs() <= 1e-13 + bound(&a) + bound(&b), "{a:?}\n{b:?}");
    }

    #[test]
    fn pieces_of_a_source_add_up_to_it(
        (a, b) in (0.2..0.8, 0.2..0.8), center in vector(0.7), occluders in vec(figure(1.5), 0..4), n in normal(),
        columns in 1..5, rows in 1..4,
    ) {
        let center = center + DVec3::Z * 3.0;
        let (u, v) = (DVec3::X * (2.0 * a), DVec3::new(0.0, -1.6, 1.2) * b);
        let whole = Shape::Rectangle(Rectangle::new(center, u, v).unwrap());
        let (du, dv) = (u / f64::from(columns), v / f64::from(rows));
        let pieces: Vec<Shape> = (0..columns * rows).map(|k| {
            let at = |i: i32, of: i32| f64::from(i) + 0.5 - 0.5 * f64::from(of);
            let center = center + du * at(k % columns, columns) + dv * at(k / columns, rows);
            Shape::Rectangle(Rectangle::new(center, du, dv).unwrap())
        }).collect();
        let one = truth(&[whole], &shapes(&occluders), DVec3::ZERO, n);
        let many = truth(&pieces, &shapes(&occluders), DVec3::ZERO, n);
        prop_assert!((factor(&one) - factor(&many)).abs() <= 1e-14 + bound(&one) + bound(&many), "{one:?}\n{many:?}");
    }

    #[test]
    fn a_meshed_rectangle_blocks_like_the_rectangle(
        source in source(), center in vector(0.5), (a, b) in (0.2..0.8, 0.2..0.8), n in normal(), levels in 0..4u32,
    ) {
        let center = center + DVec3::Z * 1.5;
        let plate = Rectangle::new(center, DVec3::X * a, DVec3::new(0.0, 0.8, 0.6) * b).unwrap();
        let corners = plate.corners();
        let mesh = Mesh::new(corners.to_vec(), vec![[0, 1, 2], [0, 3, 2]]).unwrap().subdivided(levels);
        let one = truth(&[source.shape()], &[Shape::Rectangle(plate)], DVec3::ZERO, n);
        let many = truth(&[source.shape()], &[Shape::Mesh(mesh)], DVec3::ZERO, n);
        prop_assert!((factor(&one) - factor(&many)).abs() <= 1e-14 + bound(&one) + bound(&many), "{one:?}\n{many:?}");
    }

    /// A closed box around the point sees the point's whole hemisphere.
    #[test]
    fn a_box_around_the_point_closes_the_hemisphere(at in vector(0.9), n in vector(1.0).prop_filter("a direction", |v| v.length() > 0.05)) {
        let walls: Vec<Shape> = [DVec3::X, DVec3::Y, DVec3::Z].iter().flat_map(|w| [*w, -*w]).map(|w| {
            let frame = Frame::around(-w);
            Shape::Rectangle(Rectangle::new(w, frame.tangent * 2.0, frame.bitangent * 2.0).unwrap())
        }).collect();
        let t = truth(&walls, &[], at, n);
        prop_assert!((factor(&t) - 1.0).abs() <= 1e-14 + bound(&t), "{t:?}");
    }
}

/// Flux that a rectangle receives from another of exitance 1, W: the exact inner factor, outer cubature.
fn flux(from: &Rectangle, to: &Rectangle, occluders: &[Shape], nodes: u32) -> f64 {
    let gauss = Gauss::new(nodes);
    let corner = to.corners()[0];
    let at = |s: f64, t: f64| {
        let position = corner + to.edge_u() * s + to.edge_v() * t;
        factor(&truth(&[Shape::Rectangle(*from)], occluders, position, to.normal()))
    };
    gauss.over([0.0, 1.0], |s| gauss.over([0.0, 1.0], |t| at(s, t))) * to.area()
}

#[test]
fn what_one_patch_sends_another_it_would_receive_from_it() {
    let a = Rectangle::new(DVec3::ZERO, DVec3::X, DVec3::Y * 0.8).unwrap();
    let b = Rectangle::new(DVec3::new(0.3, 0.4, 1.2), DVec3::new(0.6, 0.0, 0.8) * 0.7, DVec3::new(0.0, -0.5, 0.0))
        .unwrap();
    let (forth, back) = (flux(&a, &b, &[], 24), flux(&b, &a, &[], 24));
    assert!((forth - back).abs() <= 1e-13 * forth, "{forth} against {back}");
    // Behind a ball the inner factor has kinks (in the 3/2 power): the outer rule is worth fewer digits.
    let ball = [Shape::Sphere(Sphere::new(DVec3::new(0.15, 0.2, 0.5), 0.2).unwrap())];
    let (forth, back) = (flux(&a, &b, &ball, 48), flux(&b, &a, &ball, 48));
    assert!((forth - back).abs() <= 1e-5 * forth, "{forth} against {back}");
}

#[test]
fn the_lectures_three_regions_are_told_apart() {
    let source = [Shape::Disk(Disk::new(DVec3::Z * 2.0, -DVec3::Z, 0.5).unwrap())];
    let occluder = [Shape::Disk(Disk::new(DVec3::Z, DVec3::Z, 0.4).unwrap())];
    let region = |x: f64| truth(&source, &occluder, DVec3::X * x, DVec3::Z).region;
    // Umbra up to 2·0.4 − 0.5 = 0.3, penumbra up to 2·0.4 + 0.5 = 1.3.
    let told = [(0.0, Region::Umbra), (0.29, Region::Umbra), (0.31, Region::Penumbra), (1.29, Region::Penumbra)];
    for (x, expected) in told.into_iter().chain([(1.31, Region::Lit)]) {
        assert_eq!(region(x), expected, "at {x}");
    }
    let behind = truth(&source, &occluder, DVec3::ZERO, -DVec3::Z);
    assert_eq!((behind.region, factor(&behind), bound(&behind)), (Region::BelowHorizon, 0.0, 0.0));
}

/// Each row: what it is, source, occluders, position, expected form factor, expected region. The receiver looks up.
#[test]
fn degenerate_cases_have_the_answers_that_were_fixed_for_them() {
    let disk = |c: DVec3, w: DVec3, r: f64| Shape::Disk(Disk::new(c, w, r).unwrap());
    let ball = |c: DVec3, r: f64| Shape::Sphere(Sphere::new(c, r).unwrap());
    let square = |c: DVec3, u: DVec3, v: DVec3| Shape::Rectangle(Rectangle::new(c, u, v).unwrap());
    let (o, x, y, z) = (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z);
    let lamp = || disk(z * 2.0, -z, 1.0);
    let wall = || square(x * 2.0 + z, y * 2.0, -z * 2.0);
    let above = truth(&[lamp()], &[], o, z).form_factor.ratio();
    let rows: Vec<(&str, Shape, Vec<Shape>, f64, Region)> = vec![
        ("in the source's plane, beside it", disk(x * 3.0, -z, 1.0), vec![], 0.0, Region::BelowHorizon),
        ("behind the source", disk(z * 2.0, z, 1.0), vec![], 0.0, Region::BelowHorizon),
        ("source seen edge-on", disk(z * 2.0, x, 1.0), vec![], 0.0, Region::BelowHorizon),
        ("source below the horizon", disk(-z, z, 1.0), vec![], 0.0, Region::BelowHorizon),
        ("inside a sphere source", ball(z * 0.5, 1.0), vec![], 0.0, Region::BelowHorizon),
        ("inside a ball", lamp(), vec![ball(z * 0.25, 0.5)], 0.0, Region::Umbra),
        ("shadow fits the source", lamp(), vec![disk(z, z, 0.5)], 0.0, Region::Umbra),
        ("occluder seen edge-on", lamp(), vec![disk(z, x, 0.5)], above, Region::Lit),
        ("occluder behind the source", lamp(), vec![disk(z * 3.0, z, 9.0)], above, Region::Lit),
        ("occluder behind the receiver", lamp(), vec![disk(-z, z, 9.0)], above, Region::Lit),
        ("occluder in the source's plane", lamp(), vec![square(z * 2.0, x, y)], above, Region::Lit),
        ("shadow touches the source", lamp(), vec![disk(x * 0.75 + z, z, 0.25)], above, Region::Lit),
        ("straight shadow touches the source", lamp(), vec![square(x + z, x, y)], above, Region::Lit),
        ("wall on the horizon", wall(), vec![], truth(&[wall()], &[], o, z).form_factor.ratio(), Region::Lit),
        ("half hidden", lamp(), vec![square(x * 8.0 + z, x * 16.0, y * 16.0)], 0.5 * above, Region::Penumbra),
        (
            "two halves",
            lamp(),
            vec![square(x * 8.0 + z, x * 16.0, y * 16.0), square(-x * 8.0 + z, x * 16.0, y * 16.0)],
            0.0,
            Region::Umbra,
        ),
        (
            "two halves of other heights",
            lamp(),
            vec![square(x * 8.0 + z, x * 16.0, y * 16.0), square(-x * 8.0 + z * 0.5, x * 16.0, y * 16.0)],
            0.0,
            Region::Umbra,
        ),
    ];
    for (name, source, occluders, expected, region) in rows {
        let t = truth(&[source], &occluders, o, z);
        assert_eq!(t.region, region, "{name}: {t:?}");
        assert!((factor(&t) - expected).abs() <= bound(&t) + 1e-15 * expected, "{name}: {t:?}, expected {expected}");
    }
}

#[test]
fn a_contact_at_the_middle_of_an_edge_is_not_a_shadow_over_all_of_it() {
    // The ball's silhouette touches the rectangle's shadow where a probe at half the edge would look.
    let flat = |z: f64, a: f64, b: f64, c: f64, d: f64, down: f64| {
        let (center, u, v) =
            (DVec3::new(0.5 * (a + b), 0.5 * (c + d), z), DVec3::X * (b - a), DVec3::Y * (d - c) * down);
        Shape::Rectangle(Rectangle::new(center, u, v).unwrap())
    };
    let source = flat(4.0, -2.0, 2.0, -2.0, 2.0, -1.0);
    let occluders =
        [flat(3.0, -1.0, 1.0, -0.5, 0.0, 1.0), Shape::Sphere(Sphere::new(DVec3::new(0.0, 0.5, 3.0), 0.5).unwrap())];
    let t = truth(&[source], &occluders, DVec3::ZERO, DVec3::new(0.0, -0.5, 1.0));
    assert!((factor(&t) - 0.1621).abs() < 5e-5, "{t:?}");
}
