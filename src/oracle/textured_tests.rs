//! Textured sources: closed forms against strips, sums against the whole, and the spread of what their samples bring.

use std::f64::consts::PI;

use glam::DVec3;
use proptest::prelude::*;

use super::body::Body;
use super::quadrature::rule::{self, Demand, Ends};
use super::quadrature::{self, Grain};
use super::textured;
use super::variance::Contribution;
use super::{ExitancePolynomial, Method, Oracle, Truth};
use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use crate::geometry::{Disk, MapTriangle, Parametrisation, Polygon, Rectangle, Shape, Sphere, TexelGrid};
use crate::number::gauss_10;
use crate::texture::{Lookup, OnRectangle, Raster, Texels, Texture};

fn point(x: f64, y: f64) -> MeasurementPoint {
    MeasurementPoint::new(DVec3::new(x, y, 0.0), DVec3::new(0.1, -0.2, 1.0)).unwrap()
}

/// Shapes over the origin with their maps.
fn canvases() -> Vec<(Shape, Parametrisation)> {
    let rectangle = Rectangle::new(DVec3::new(0.1, 0.2, 2.0), DVec3::Y * 1.3, DVec3::X * 0.9).unwrap();
    let disk = Disk::new(DVec3::new(0.1, 0.2, 2.0), DVec3::new(0.2, 0.1, -1.0), 0.7).unwrap();
    let globe = Sphere::new(DVec3::new(0.1, 0.2, 2.0), 0.6).unwrap();
    let vertices = [DVec3::new(-0.5, -0.4, 2.0), DVec3::new(0.1, 0.8, 1.7), DVec3::new(0.9, -0.2, 2.1)];
    let triangle = Polygon::new(vertices.to_vec()).unwrap();
    let similar = MapTriangle::similar_to(vertices).unwrap();
    // Clockwise in the map: a mirrored picture.
    let mirrored = MapTriangle::new([[0.1, 0.1], [0.2, 0.9], [0.95, 0.3]]).unwrap();
    vec![
        (Shape::Rectangle(rectangle), Parametrisation::rectangle(&rectangle)),
        (Shape::Polygon(triangle.clone()), Parametrisation::triangle(vertices, MapTriangle::HALF_SQUARE).unwrap()),
        (Shape::Polygon(triangle.clone()), Parametrisation::triangle(vertices, similar).unwrap()),
        (Shape::Polygon(triangle), Parametrisation::triangle(vertices, mirrored).unwrap()),
        (Shape::Disk(disk), Parametrisation::disk(&disk, Some(DVec3::X)).unwrap()),
        (
            Shape::Sphere(globe),
            Parametrisation::sphere(&globe, DVec3::new(0.1, 0.7, 0.4), DVec3::new(0.3, 0.2, -1.0)).unwrap(),
        ),
    ]
}

fn occluders() -> Vec<Shape> {
    vec![
        Shape::Sphere(Sphere::new(DVec3::new(0.15, 0.0, 1.0), 0.12).unwrap()),
        Shape::Disk(Disk::new(DVec3::new(-0.2, 0.2, 0.9), DVec3::new(0.1, 0.3, 1.0), 0.2).unwrap()),
    ]
}

fn room(shape: &Shape, texture: Texture, occluders: Vec<Shape>, points: Vec<MeasurementPoint>) -> Configuration {
    let source = Source::textured(shape.clone(), texture).unwrap();
    Configuration::new(vec![source], occluders, None, points, Arrangement::Scattered).unwrap()
}

fn raster(ns: usize, nt: usize) -> Raster {
    let grid = TexelGrid::new(ns, nt).unwrap();
    // Some equal neighbours, some zeros.
    Raster::new(grid, grid.texels().map(|texel| ((texel.i / 2 + 3 * texel.j) % 4) as f64 * 0.5).collect()).unwrap()
}

fn apart(a: &Truth, b: &Truth) -> (f64, f64) {
    let value = |t: &Truth| t.irradiance.watts_per_square_metre();
    let bound = |t: &Truth| t.bound.watts_per_square_metre();
    ((value(a) - value(b)).abs(), bound(a) + bound(b))
}

/// Polygons in closed form against strips parted at the texels' borders, which share nothing but the shapes.
#[test]
fn sums_over_texels_agree_with_strips() {
    for (k, (shape, map)) in canvases().into_iter().enumerate() {
        let texture = Texture::Texels(Texels::new(map, raster(5, 3), Lookup::Nearest));
        for occluders in [vec![], occluders()] {
            let points: Vec<_> = [0.0, 0.4, -1.5].map(|x| point(x, 0.1)).to_vec();
            let room = room(&shape, texture.clone(), occluders, points.clone());
            let oracle = Oracle::new(&room);
            for p in &points {
                let (truth, strips) = (oracle.at(p), oracle.by_quadrature(p));
                let (off, allowed) = apart(&truth, &strips);
                assert_eq!(truth.method, if k < 4 { Method::ClosedForm } else { Method::Quadrature });
                assert!(allowed < 1e-11, "{k}: bounds of {allowed:e}");
                assert!(off <= allowed + 1e-15, "{k}: off by {off:e}, allowed {allowed:e}: {truth:?} {strips:?}");
            }
        }
    }
}

/// A third route for globes: texel by texel over the surface itself, along its latitudes.
#[test]
fn a_globe_is_the_sum_over_its_surface() {
    let globe = Sphere::new(DVec3::new(0.1, 0.2, 2.0), 0.6).unwrap();
    let (north, equator) = (DVec3::new(0.1, 0.7, 0.4), DVec3::new(0.3, 0.2, -1.0));
    for (ns, nt) in [(3, 2), (5, 4)] {
        let map = Parametrisation::sphere(&globe, north, equator).unwrap();
        let texture = Texture::Texels(Texels::new(map, raster(ns, nt), Lookup::Nearest));
        for p in [point(0.3, -0.2), point(-0.9, 0.4)] {
            let truth = Oracle::new(&room(&Shape::Sphere(globe), texture.clone(), vec![], vec![p])).at(&p);
            let radius = globe.radius();
            let to_eye = p.position() - globe.center();
            let brought = |s: f64, t: f64| {
                let at = map.to_surface([s, t]);
                let way = at - p.position();
                let normal = (at - globe.center()) / radius;
                let cosines = p.normal().dot(way).max(0.0) * (-normal.dot(way)).max(0.0);
                let area = radius * radius * 2.0 * PI * PI * (PI * t).sin();
                area * texture.at(at) * cosines / (PI * way.length_squared().powi(2))
            };
            // Between the borders of texels and the ends of the part of a latitude that faces the eye.
            let along = |t: f64| {
                let faces = |s: f64| (map.to_surface([s, t]) - globe.center()).dot(to_eye) / radius - radius;
                let [first, quarter, half] = [0.0, 0.25, 0.5].map(faces);
                let middle = 0.5 * (first + half);
                let (x, y) = (0.5 * (first - half), quarter - middle);
                let mut ends: Vec<f64> = (0..=ns).map(|i| i as f64 / ns as f64).collect();
                let cosine = -middle / x.hypot(y);
                if cosine.abs() < 1.0 {
                    let turns = [-1.0, 1.0].map(|sign| (y.atan2(x) + sign * cosine.acos()) / (2.0 * PI));
                    ends.extend(turns.map(|s| s.rem_euclid(1.0)));
                }
                ends.sort_by(f64::total_cmp);
                let parts = ends.windows(2).map(|end| (0.5 * (end[0] + end[1]), 0.5 * (end[1] - end[0])));
                let quarters = |(middle, half): (f64, f64)| {
                    let part = |k: f64| gauss_10(middle + 0.25 * k * half, 0.25 * half, |s| brought(s, t));
                    [-3.0, -1.0, 1.0, 3.0].map(part).iter().sum::<f64>()
                };
                parts.map(quarters).sum::<f64>()
            };
            // Rows of texels, and where the horizon touches a latitude.
            let pole = (map.to_surface([0.0, 1.0]) - globe.center()).normalize();
            let from_south = PI - pole.angle_between(to_eye);
            let cap = (radius / to_eye.length()).acos();
            let mut rows: Vec<f64> = (0..=nt).map(|j| j as f64 / nt as f64).collect();
            rows.extend([from_south - cap, from_south + cap].map(|angle| (angle / PI).clamp(0.0, 1.0)));
            // A pole within sight: the horizon's turn there.
            rows.extend([-from_south + cap, 2.0 * PI - from_south - cap].map(|angle| (angle / PI).clamp(0.0, 1.0)));
            rows.sort_by(f64::total_cmp);
            let demand = |sum: &[f64; 1]| Demand { goal: [1e-13 * sum[0]], floor: |value| [1e-16 * value[0]] };
            let sum = rule::integrate(&rows, Ends::Roots, 1e-9, 20_000, |t| [along(t)], demand).value[0];
            let found = truth.irradiance.watts_per_square_metre();
            assert!((sum / found - 1.0).abs() < 1e-10, "{ns} × {nt}: {sum}, not {found}: {truth:?}");
        }
    }
}

/// A third route, which knows nothing of borders: it searches for jumps, and takes long.
#[test]
fn known_seams_agree_with_searched_ones() {
    for (shape, map) in canvases().into_iter().skip(4) {
        for lookup in [Lookup::Nearest, Lookup::Bilinear] {
            // Texels of a globe end in points at its poles, which the search steps over (it was off by 3e-7):
            // `a_globe_is_the_sum_over_its_surface` has them.
            if lookup == Lookup::Nearest && matches!(shape, Shape::Sphere(_)) {
                continue;
            }
            let texture = Texture::Texels(Texels::new(map, raster(3, 2), lookup));
            let p = point(0.3, -0.2);
            let room = room(&shape, texture.clone(), occluders(), vec![p]);
            let oracle = Oracle::new(&room);
            let truth = oracle.at(&p);
            let searched = oracle.by_quadrature_with(&p, &|_, at| texture.at(at));
            let (off, allowed) = apart(&truth, &searched);
            assert!(truth.bound.watts_per_square_metre() < 1e-10, "{truth:?}");
            // Sectors come to a point in the middle of a disk, narrower there than what the search resolves: it was off by 4e-9
            // and knew of 2e-10. `a_sector_is_a_disk_behind_a_screen` tells which of the two is right.
            let unseen = 2e-8;
            assert!(off <= allowed + unseen, "{} {lookup:?}: off by {off:e}, allowed {allowed:e}", shape.kind());
        }
    }
}

#[test]
fn an_even_texture_is_no_texture() {
    for (k, (shape, map)) in canvases().into_iter().enumerate() {
        for lookup in [Lookup::Nearest, Lookup::Bilinear] {
            let even = Raster::checker(TexelGrid::new(4, 3).unwrap(), 1.5, 1.5).unwrap();
            let texture = Texture::Texels(Texels::new(map, even, lookup));
            let p = point(0.3, -0.2);
            let truth = Oracle::new(&room(&shape, texture, occluders(), vec![p])).at(&p);
            let factor = truth.form_factor.ratio();
            let off = (truth.irradiance.watts_per_square_metre() - 1.5 * factor).abs();
            assert!(off < 1e-12, "{k} {lookup:?}: off by {off:e}");
        }
    }
}

#[test]
fn bands_of_a_disk_are_differences_of_disks() {
    // Rings of equal area: a disk of radius R √½ of exitance 2, and what is around it of exitance 1.
    let disk = Disk::new(DVec3::Z * 2.0, -DVec3::Z, 0.8).unwrap();
    let inner = Disk::new(DVec3::Z * 2.0, -DVec3::Z, 0.8 * 0.5_f64.sqrt()).unwrap();
    let rings = Raster::new(TexelGrid::new(1, 2).unwrap(), vec![2.0, 1.0]).unwrap();
    let map = Parametrisation::disk(&disk, None).unwrap();
    let texture = Texture::Texels(Texels::new(map, rings, Lookup::Nearest));
    let p = point(0.4, 0.1);
    let factor = |disk: Disk| {
        let source = Source::new(Shape::Disk(disk), crate::radiometry::Exitance::new(1.0)).unwrap();
        let room = Configuration::new(vec![source], occluders(), None, vec![p], Arrangement::Scattered).unwrap();
        Oracle::new(&room).at(&p).form_factor.ratio()
    };
    let found = Oracle::new(&room(&Shape::Disk(disk), texture, occluders(), vec![p])).at(&p);
    let expected = factor(disk) + factor(inner);
    let off = (found.irradiance.watts_per_square_metre() - expected).abs();
    assert!(off <= found.bound.watts_per_square_metre() + 1e-15, "off by {off:e}: {found:?}");
}

/// From straight below, half of what is seen of a globe with a bright hemisphere is bright, whichever way its poles lie.
#[test]
fn half_a_globe_brings_half_its_light() {
    let globe = Sphere::new(DVec3::Z * 2.0, 0.7).unwrap();
    let p = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
    let whole = (0.7_f64 / 2.0).powi(2);
    // s = 0 and s = ½ in the plane of sight, or the equator.
    for (ns, nt, north, equator) in
        [(2, 1, DVec3::Z, DVec3::X), (1, 2, DVec3::X, DVec3::Z), (2, 1, DVec3::X, DVec3::Z)]
    {
        let map = Parametrisation::sphere(&globe, north, equator).unwrap();
        let halves = Raster::checker(TexelGrid::new(ns, nt).unwrap(), 1.0, 0.0).unwrap();
        let texture = Texture::Texels(Texels::new(map, halves, Lookup::Nearest));
        let found = Oracle::new(&room(&Shape::Sphere(globe), texture, vec![], vec![p])).at(&p);
        let off = (found.irradiance.watts_per_square_metre() - 0.5 * whole).abs();
        assert!(off <= found.bound.watts_per_square_metre() + 1e-15, "off by {off:e}: {found:?}");
    }
    // And all of it, or nothing, with the poles along the line of sight.
    for (values, expected) in [(vec![1.0, 0.0], whole), (vec![0.0, 1.0], 0.0)] {
        let map = Parametrisation::sphere(&globe, DVec3::Z, DVec3::X).unwrap();
        let halves = Raster::new(TexelGrid::new(1, 2).unwrap(), values).unwrap();
        let texture = Texture::Texels(Texels::new(map, halves, Lookup::Nearest));
        let found = Oracle::new(&room(&Shape::Sphere(globe), texture, vec![], vec![p])).at(&p);
        let off = (found.irradiance.watts_per_square_metre() - expected).abs();
        assert!(off <= found.bound.watts_per_square_metre() + 1e-15, "off by {off:e}: {found:?}");
    }
}

#[test]
fn a_polynomial_source_is_its_polynomial() {
    let (shape, _) = canvases().swap_remove(0);
    let Shape::Rectangle(rectangle) = shape.clone() else { panic!("a rectangle") };
    let polynomial = ExitancePolynomial { e00: 2.0, e10: 0.7, e01: -0.4, e20: -1.0, e11: 0.9, e02: -2.0 };
    let texture = Texture::Polynomial(OnRectangle::new(rectangle, polynomial).unwrap());
    let p = MeasurementPoint::new(DVec3::new(0.2, 0.1, 0.0), DVec3::Z).unwrap();
    for occluders in [vec![], occluders()] {
        let oracle = Oracle::new(&room(&shape, texture.clone(), occluders, vec![p]));
        let truth = oracle.at(&p);
        let strips = oracle.by_quadrature_with(&p, &|_, at| polynomial.value_at(&rectangle, at));
        let (off, allowed) = apart(&truth, &strips);
        assert!(off <= allowed + 1e-15 && allowed < 1e-10, "off by {off:e}, allowed {allowed:e}");
    }
}

#[test]
fn nothing_comes_from_a_textured_source_that_is_hidden_or_turned_away() {
    let cover = Shape::Rectangle(Rectangle::new(DVec3::Z, DVec3::X * 9.0, DVec3::Y * 9.0).unwrap());
    for (shape, map) in canvases() {
        let texture = Texture::Texels(Texels::new(map, raster(4, 3), Lookup::Nearest));
        let below = MeasurementPoint::new(DVec3::ZERO, -DVec3::Z).unwrap();
        let covered = room(&shape, texture.clone(), vec![cover.clone()], vec![point(0.0, 0.0)]);
        let truth = Oracle::new(&covered).at(&point(0.0, 0.0));
        assert_eq!([truth.irradiance, truth.bound].map(|x| x.watts_per_square_metre()), [0.0, 0.0]);
        assert!(truth.unoccluded_irradiance.watts_per_square_metre() > 0.0);
        let truth = Oracle::new(&room(&shape, texture, vec![], vec![below])).at(&below);
        assert_eq!([truth.irradiance, truth.bound].map(|x| x.watts_per_square_metre()), [0.0, 0.0]);
    }
}

/// Second moments against an irradiance: E X² = ∫ A M² k · k dA, the irradiance of a source whose exitance is A M² k.
#[test]
fn predicted_spreads_know_the_texture() {
    for (k, (shape, map)) in canvases().into_iter().enumerate() {
        for lookup in [Lookup::Nearest, Lookup::Bilinear] {
            let texture = Texture::Texels(Texels::new(map, raster(5, 3), lookup));
            let p = point(0.3, -0.2);
            let room = room(&shape, texture.clone(), occluders(), vec![p]);
            let oracle = Oracle::new(&room);
            let area = shape.area();
            let squared = |at: DVec3| {
                let way = at - p.position();
                let normal = match &shape {
                    Shape::Disk(s) => s.normal(),
                    Shape::Rectangle(s) => s.normal(),
                    Shape::Polygon(s) => s.normal(),
                    Shape::Sphere(s) => (at - s.center()).normalize(),
                    Shape::Mesh(_) => panic!("no source"),
                };
                let cosines = p.normal().dot(way).max(0.0) * (-normal.dot(way)).max(0.0);
                area * texture.at(at).powi(2) * cosines / (std::f64::consts::PI * way.length_squared().powi(2))
            };
            let body = &oracle.sources[0].body;
            let others: Vec<&Body> = oracle.occluders.iter().collect();
            let emission = |place: DVec3| squared((body.center + place) / oracle.scale);
            // The kernel varies between the seams.
            let grain = Grain { is_constant_between: false, ..textured::grain(&texture, body.center, oracle.scale) };
            let eye = p.position() * oracle.scale;
            let expected =
                quadrature::visible_between(p.normal(), body, &others, eye, &emission, &grain, textured::ROUGH);
            let moments = oracle.area_moments(0, &p).unwrap();
            let mean = moments.first_moment();
            let square = moments.spread().variance + mean * mean;
            let due = oracle.at(&p).irradiance.watts_per_square_metre();
            let value = expected.value;
            assert!((mean / due - 1.0).abs() < 1e-3, "{k} {lookup:?}: mean {mean}, not {due}");
            assert!((square / value - 1.0).abs() < 1e-3, "{k} {lookup:?}: {square}, not {value}");
            let cosine = oracle.sample_moments(0, &p, Contribution::by_cosine).unwrap().first_moment();
            assert!((cosine / due - 1.0).abs() < 1e-3, "{k} {lookup:?}: {cosine} by cosine, not {due}");
        }
    }
}

/// A sector of a disk is the disk behind a screen with an opening: a polygon half way to the eye that hides the rest of it.
#[test]
fn a_sector_is_a_disk_behind_a_screen() {
    let disk = Disk::new(DVec3::new(0.1, 0.2, 2.0), DVec3::new(0.2, 0.1, -1.0), 0.7).unwrap();
    let map = Parametrisation::disk(&disk, Some(DVec3::X)).unwrap();
    for k in 0..5 {
        let mut values = vec![0.0; 5];
        values[k] = 1.0;
        let sectors = Raster::new(TexelGrid::new(5, 1).unwrap(), values).unwrap();
        let texture = Texture::Texels(Texels::new(map, sectors, Lookup::Nearest));
        // Around the disk, from the end of the sector to where it begins, and back by its tip.
        let far = |turn: f64| disk.center() + 3.0 * (map.to_surface([turn, 1.0]) - disk.center());
        let mut screen: Vec<DVec3> = (0..=4).map(|i| far((k as f64 + 1.0 + f64::from(i)) / 5.0)).collect();
        screen.push(disk.center());
        for p in [point(0.3, -0.2), point(-0.7, 0.4), point(0.1, 0.2)] {
            let half_way = screen.iter().map(|q| p.position() + 0.5 * (*q - p.position())).collect();
            let screen = Shape::Polygon(Polygon::new(half_way).unwrap());
            let source = Source::new(Shape::Disk(disk), crate::radiometry::Exitance::new(1.0)).unwrap();
            let mut blockers = occluders();
            blockers.push(screen);
            let screened = Configuration::new(vec![source], blockers, None, vec![p], Arrangement::Scattered).unwrap();
            let expected = Oracle::new(&screened).at(&p);
            let found = Oracle::new(&room(&Shape::Disk(disk), texture.clone(), occluders(), vec![p])).at(&p);
            let (off, allowed) = apart(&found, &expected);
            // The screen's corners are rounded.
            assert!(off <= allowed + 1e-15, "{k}: off by {off:e}, allowed {allowed:e}");
        }
    }
}

/// A cap that is seen wholly fills the same directions as the disk that closes it, wherever its pole lies.
#[test]
fn a_cap_of_a_globe_is_the_disk_that_closes_it() {
    let globe = Sphere::new(DVec3::new(0.1, 0.2, 2.0), 0.6).unwrap();
    for south in [DVec3::new(0.0, 0.1, -1.0), DVec3::new(0.3, -0.2, -1.0), DVec3::new(-0.5, 0.4, -1.0)] {
        let map = Parametrisation::sphere(&globe, -south, DVec3::X).unwrap();
        // Narrow enough to be seen wholly.
        for nt in [7, 9, 12] {
            let mut values = vec![0.0; nt];
            values[0] = 1.0;
            let cap = Raster::new(TexelGrid::new(1, nt).unwrap(), values).unwrap();
            let texture = Texture::Texels(Texels::new(map, cap, Lookup::Nearest));
            let (sin, cos) = (std::f64::consts::PI / nt as f64).sin_cos();
            let (axis, radius) = (south.normalize(), globe.radius());
            let closing = Disk::new(globe.center() + axis * (radius * cos), axis, radius * sin).unwrap();
            for p in [point(0.3, -0.2), point(0.1, 0.2)] {
                let source = Source::new(Shape::Disk(closing), crate::radiometry::Exitance::new(1.0)).unwrap();
                let flat =
                    Configuration::new(vec![source], occluders(), None, vec![p], Arrangement::Scattered).unwrap();
                let expected = Oracle::new(&flat).at(&p);
                let found = Oracle::new(&room(&Shape::Sphere(globe), texture.clone(), occluders(), vec![p])).at(&p);
                let (off, allowed) = apart(&found, &expected);
                assert!(off <= allowed + 1e-15, "{nt} {south}: off by {off:e}, allowed {allowed:e}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]
    /// Wherever the eye is, however the globe is turned: parts add up to the whole that they are parts of.
    #[test]
    fn a_picture_and_its_negative_make_an_even_source(
        (x, y) in (-1.5..1.5, -1.5..1.5),
        (a, b, c) in (-1.0..1.0, -1.0..1.0, -1.0..1.0),
        k in 0..6_usize,
    ) {
        let (shape, mut map) = canvases().swap_remove(k);
        if let Shape::Sphere(globe) = &shape {
            let Ok(turned) = Parametrisation::sphere(globe, DVec3::new(a, b, c), DVec3::new(c, a, -b)) else { return Ok(()) };
            map = turned;
        }
        let p = point(x, y);
        let light = |bright: f64, dark: f64| {
            let board = Raster::checker(TexelGrid::new(4, 3).unwrap(), bright, dark).unwrap();
            let texture = Texture::Texels(Texels::new(map, board, Lookup::Nearest));
            Oracle::new(&room(&shape, texture, occluders(), vec![p])).at(&p)
        };
        let (picture, negative) = (light(1.0, 0.0), light(0.0, 1.0));
        let sum = picture.irradiance.watts_per_square_metre() + negative.irradiance.watts_per_square_metre();
        let allowed = picture.bound.watts_per_square_metre() + negative.bound.watts_per_square_metre();
        let off = (sum - picture.form_factor.ratio()).abs();
        prop_assert!(allowed < 1e-10, "a bound of {:e}", allowed);
        prop_assert!(off <= allowed + 1e-14, "{}: off by {:e}, allowed {:e}", k, off, allowed);
    }
}
