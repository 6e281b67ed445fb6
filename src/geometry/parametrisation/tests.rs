//! The laws of every map: there and back, areas that add up, poles and seams that are no exception.

use super::*;
use crate::number::gauss_10;
use proptest::prelude::*;

fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
    let x = move || -reach..reach;
    (x(), x(), x()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// Any surface with any map, some metres from the origin.
fn parametrisation() -> impl Strategy<Value = Parametrisation> {
    (vector(2.0), vector(1.0), vector(1.0), 0.1..3.0, 0.1..3.0, 0..5).prop_filter_map(
        "a surface with a map",
        |(center, axis, other, a, b, kind)| {
            let axis = axis.try_normalize()?;
            if axis.cross(other).length() < 0.1 {
                return None;
            }
            let frame = Frame::around(axis);
            let (u, v) = (frame.tangent * a, frame.bitangent * b);
            Some(match kind {
                0 => Parametrisation::rectangle(&Rectangle::new(center, u, v).ok()?),
                1 => Parametrisation::disk(&Disk::new(center, axis, a).ok()?, Some(other)).ok()?,
                2 => Parametrisation::sphere(&Sphere::new(center, a).ok()?, axis, other).ok()?,
                3 => {
                    Parametrisation::triangle([center, center + u, center + other], MapTriangle::HALF_SQUARE).ok()?
                }
                _ => {
                    let vertices = [center, center + u, center + other];
                    Parametrisation::triangle(vertices, MapTriangle::similar_to(vertices).ok()?).ok()?
                }
            })
        },
    )
}

/// The point of the map that is meant by two numbers of [0, 1]: on the surface, whatever the map covers.
fn covered(map: &Parametrisation, [s, t]: [f64; 2]) -> [f64; 2] {
    match map.map_triangle() {
        None => [s, t],
        Some(triangle) => triangle.at([(1.0 - s) * t.sqrt(), s * t.sqrt()]),
    }
}

/// How far along a sliver of a triangle a point may move, metres, as its coordinates are rounded: by its height in
/// proportion to its longest side.
fn doubt(map: &Parametrisation, point: DVec3) -> f64 {
    let Some(triangle) = map.map_triangle() else { return 0.0 };
    let [a, b, c] = triangle.corners().map(|corner| map.to_surface(corner));
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let size = [a, b, c, point].map(|p| p.abs().max_element()).into_iter().fold(0.0, f64::max);
    4.0 * f64::EPSILON * size * longest * longest / (2.0 * map.area())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn there_and_back_is_where_it_began(map in parametrisation(), s in 0.0..1.0, t in 0.0..1.0) {
        let at = covered(&map, [s, t]);
        let point = map.to_surface(at);
        let back = map.to_map(point);
        let size = map.area().sqrt();
        let slack = 1e-12 + doubt(&map, point) / size;
        prop_assert!((map.to_surface(back) - point).length() <= slack * size, "{map:?} at {at:?}: {back:?}");
        // Near a pole a whole turn is a short way: there s has fewer digits.
        let around = match map.poles() {
            [false, _] => 1.0,
            [true, true] => (PI * t).sin(),
            [true, false] => t.sqrt(),
        };
        let apart = if map.wraps() { (back[0] - at[0]).abs().min(1.0 - (back[0] - at[0]).abs()) } else { (back[0] - at[0]).abs() };
        prop_assert!(around * apart <= slack && (back[1] - at[1]).abs() <= slack, "{map:?} at {at:?}: {back:?}");
    }

    #[test]
    fn texel_areas_add_up_to_the_surface(map in parametrisation(), ns in 1..40_usize, nt in 1..40_usize) {
        let grid = TexelGrid::new(ns, nt).unwrap();
        let sum: f64 = grid.texels().map(|texel| map.texel_area(grid, texel)).sum();
        prop_assert!((sum / map.area() - 1.0).abs() <= 1e-12, "{map:?}: {sum}");
    }

    #[test]
    fn a_texel_is_the_integral_of_the_density(map in parametrisation(), i in 0..5_usize, j in 0..7_usize) {
        if map.map_triangle().is_some() {
            return Ok(());
        }
        let grid = TexelGrid::new(5, 7).unwrap();
        let [[s0, s1], [t0, t1]] = grid.extent(Texel { i, j });
        let integral = gauss_10(0.5 * (t0 + t1), 0.5 * (t1 - t0), |t| map.density([s0, t]) * (s1 - s0));
        let area = map.texel_area(grid, Texel { i, j });
        prop_assert!((integral / area - 1.0).abs() <= 1e-13, "{area} against {integral}");
        let shares = [t0, t1].map(|t| map.share_below(t).unwrap());
        prop_assert!(((shares[1] - shares[0]) * (s1 - s0) * map.area() / area - 1.0).abs() <= 1e-13);
    }

    /// The density is what the map does to two short steps.
    #[test]
    fn the_density_is_the_jacobian(map in parametrisation(), s in 0.05..0.95, t in 0.05..0.95) {
        let at = covered(&map, [s, t]);
        let step = 1e-4;
        let along = |ds: f64, dt: f64| map.to_surface([at[0] + ds, at[1] + dt]) - map.to_surface([at[0] - ds, at[1] - dt]);
        let jacobian = along(step, 0.0).cross(along(0.0, step)).length() / (4.0 * step * step);
        prop_assert!((jacobian / map.density(at) - 1.0).abs() <= 1e-5, "{jacobian} against {}", map.density(at));
    }

    #[test]
    fn a_similar_map_distorts_nothing(p in vector(1.0), q in vector(1.0), r in vector(1.0)) {
        let vertices = [p, q, r];
        let Ok(map) = MapTriangle::similar_to(vertices) else { return Ok(()) };
        let corners = map.corners();
        let ratio = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            (a[0] - b[0]).hypot(a[1] - b[1]) / (vertices[k] - vertices[(k + 1) % 3]).length()
        };
        prop_assert!((ratio(1) / ratio(0) - 1.0).abs() <= 1e-12 && (ratio(2) / ratio(0) - 1.0).abs() <= 1e-12);
        prop_assert!(map.twice_orientation() > 0.0, "the picture is not mirrored");
    }
}

impl MapTriangle {
    fn twice_orientation(&self) -> f64 {
        let [a, b, c] = self.corners();
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    }
}

#[test]
fn a_texel_cut_by_the_hypotenuse_has_what_is_left_of_it() {
    let triangle = [DVec3::ZERO, DVec3::X * 2.0, DVec3::Y * 3.0];
    let map = Parametrisation::triangle(triangle, MapTriangle::HALF_SQUARE).unwrap();
    let grid = TexelGrid::new(2, 2).unwrap();
    let area = |i, j| map.texel_area(grid, Texel { i, j });
    assert_eq!([area(0, 0), area(1, 0), area(0, 1), area(1, 1)], [1.5, 0.75, 0.75, 0.0]);
    // Three columns, two rows: the line s + t = 1 cuts (1, 0), (1, 1) and others where no corner lies.
    let grid = TexelGrid::new(3, 2).unwrap();
    let whole = 2.0 * 3.0 / 6.0;
    let share = |i, j| map.texel_area(grid, Texel { i, j }) / whole;
    approx::assert_abs_diff_eq!(share(0, 0), 1.0, epsilon = 1e-15);
    // Above the line at s > 1/2: a triangle of legs 1/6 in a texel of 1/3 × 1/2.
    approx::assert_abs_diff_eq!(share(1, 0), 1.0 - (1.0 / 72.0) / (1.0 / 6.0), epsilon = 1e-15);
    approx::assert_abs_diff_eq!(share(1, 1), (1.0 / 72.0) / (1.0 / 6.0), epsilon = 1e-15);
}

#[test]
fn the_poles_and_the_seam_are_points_of_the_map() {
    let globe = Sphere::new(DVec3::new(1.0, 2.0, 3.0), 0.5).unwrap();
    let map = Parametrisation::sphere(&globe, DVec3::Z, DVec3::new(1.0, 0.0, 7.0)).unwrap();
    let at = |x: f64, y: f64, z: f64| map.to_map(globe.center() + DVec3::new(x, y, z));
    assert_eq!(at(0.0, 0.0, 0.5), [0.0, 1.0]);
    assert_eq!(at(0.0, 0.0, -0.5), [0.0, 0.0]);
    assert_eq!(at(0.5, 0.0, 0.0), [0.0, 0.5], "only the part of the equator's point across north counts");
    assert_eq!(at(0.0, 0.5, 0.0), [0.25, 0.5], "eastwards");
    assert_eq!(at(-0.5, 0.0, 0.0)[0], 0.5);
    assert_eq!(at(-0.5, -0.0, 0.0)[0], 0.5, "a signed zero changes no side");
    assert_eq!(at(0.5, -1e-300, 0.0)[0], 0.0, "a whole turn is none");
    let disk = Disk::new(DVec3::Z, -DVec3::Z, 2.0).unwrap();
    let map = Parametrisation::disk(&disk, None).unwrap();
    assert_eq!(map.to_map(DVec3::Z), [0.0, 0.0]);
    assert_eq!(map.to_map(DVec3::new(0.0, -1.0, 1.0)), [0.25, 0.25], "counter-clockwise seen from below");
}

#[test]
fn what_has_no_map_is_refused() {
    let line = [DVec3::ZERO, DVec3::ONE, DVec3::ONE * 2.0];
    let refused = Parametrisation::triangle(line, MapTriangle::HALF_SQUARE);
    assert!(matches!(refused, Err(ParametrisationError::DegenerateTriangle { .. })), "{refused:?}");
    for degenerate in [[DVec3::ONE; 3], [DVec3::ZERO, DVec3::X, DVec3::X]] {
        assert!(MapTriangle::similar_to(degenerate).is_err());
    }
    let infinite = [DVec3::ZERO, DVec3::X, DVec3::new(0.0, f64::INFINITY, 0.0)];
    assert!(matches!(MapTriangle::similar_to(infinite), Err(ParametrisationError::Direction(_))));
    assert_eq!(
        MapTriangle::new([[0.0, 0.0], [1.5, 0.0], [0.0, 1.0]]),
        Err(ParametrisationError::OutsideMap { corner: 1, s: 1.5, t: 0.0 })
    );
    assert!(matches!(
        MapTriangle::new([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]]),
        Err(ParametrisationError::DegenerateMap { .. })
    ));
    let ball = Sphere::new(DVec3::ZERO, 1.0).unwrap();
    assert_eq!(
        Parametrisation::sphere(&ball, DVec3::Z, DVec3::Z * -2.0),
        Err(ParametrisationError::Aligned { field: "equator", axis: "north" })
    );
    assert!(Parametrisation::sphere(&ball, DVec3::ZERO, DVec3::X).is_err());
    assert_eq!(TexelGrid::new(0, 3), Err(ParametrisationError::NoTexels { ns: 0, nt: 3 }));
}

#[test]
fn texels_hold_their_lower_borders_and_the_last_one_both() {
    let grid = TexelGrid::new(4, 2).unwrap();
    assert_eq!(grid.texel([0.25, 0.5]), Texel { i: 1, j: 1 });
    assert_eq!(grid.texel([1.0, 1.0]), Texel { i: 3, j: 1 });
    assert_eq!(grid.texel([-0.1, f64::NAN]), Texel { i: 0, j: 0 });
    assert!(grid.texels().enumerate().all(|(k, texel)| grid.index(texel) == k));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn isolines_are_where_their_coordinate_is(map in parametrisation(), at in 0.01..0.99_f64, along in 0.01..0.99_f64) {
        for (axis, line) in [map.line_of_s(at), map.line_of_t(at)].into_iter().enumerate() {
            let point = match line {
                None => {
                    prop_assert!(map.map_triangle().is_some(), "{map:?}");
                    continue;
                }
                Some(Isoline::Segment([p, q])) => p + (q - p) * along,
                Some(Isoline::Circle { center, normal, radius }) => {
                    let frame = Frame::around(normal);
                    let (sin, cos) = (TAU * along).sin_cos();
                    center + (frame.tangent * cos + frame.bitangent * sin) * radius
                }
            };
            let found = map.to_map_from_anchor(point)[axis];
            let off = (found - at).abs();
            // A whole diameter or meridian circle: half a turn on.
            let off = if map.wraps() && axis == 0 { off.min((off - 0.5).abs()) } else { off };
            prop_assert!(off <= 1e-10, "{map:?}: {found} for {at}");
        }
    }

    #[test]
    fn a_share_of_the_area_finds_its_t(map in parametrisation(), t in 0.0..1.0_f64) {
        if let Some(share) = map.share_below(t) {
            prop_assert!((map.t_of_share(share).unwrap() - t).abs() <= 1e-13);
        }
    }
}
