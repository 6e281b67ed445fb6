//! The laws of lookups: nothing is gained or lost, constants stay what they are, seams and poles are no exception.

use super::*;
use crate::geometry::{Disk, Frame, MapTriangle, Parametrisation, Sphere, TexelGrid};
use crate::number::gauss_10;
use proptest::prelude::*;

fn maps() -> Vec<Parametrisation> {
    let triangle = [DVec3::ZERO, DVec3::X * 2.0, DVec3::new(0.7, 1.1, 0.4)];
    let rectangle = Rectangle::new(DVec3::ONE, DVec3::X * 2.0, DVec3::Z).unwrap();
    let disk = Disk::new(DVec3::ONE, DVec3::new(0.3, 0.1, -1.0), 1.5).unwrap();
    let globe = Sphere::new(DVec3::ONE, 0.7).unwrap();
    vec![
        Parametrisation::rectangle(&rectangle),
        Parametrisation::disk(&disk, None).unwrap(),
        Parametrisation::sphere(&globe, DVec3::new(0.2, 0.3, 1.0), DVec3::X).unwrap(),
        Parametrisation::triangle(triangle, MapTriangle::HALF_SQUARE).unwrap(),
        Parametrisation::triangle(triangle, MapTriangle::similar_to(triangle).unwrap()).unwrap(),
    ]
}

/// The place of the map that is meant by two numbers of [0, 1]: on the surface, whatever the map covers.
fn covered(map: &Parametrisation, [s, t]: [f64; 2]) -> [f64; 2] {
    let Some(triangle) = map.map_triangle() else { return [s, t] };
    let [q0, q1, q2] = triangle.corners();
    let (a, b) = ((1.0 - s) * t, s * t);
    [0, 1].map(|i| q0[i] + a * (q1[i] - q0[i]) + b * (q2[i] - q0[i]))
}

/// ∫ over the surface, by Gauss's rule on the pieces between the seams; and on triangles on the part that is covered.
fn by_quadrature(texels: &Texels) -> f64 {
    let (map, seams) = (texels.map(), texels.seams());
    let stops = |lines: &[f64]| {
        let mut stops: Vec<f64> = [0.0, 1.0].into_iter().chain(lines.iter().copied()).collect();
        stops.sort_by(f64::total_cmp);
        stops
    };
    let mut total = 0.0;
    for t in stops(&seams.t).windows(2) {
        for s in stops(&seams.s).windows(2) {
            total += match map.map_triangle() {
                None => gauss_10(0.5 * (t[0] + t[1]), 0.5 * (t[1] - t[0]), |t| {
                    gauss_10(0.5 * (s[0] + s[1]), 0.5 * (s[1] - s[0]), |s| {
                        texels.at_map([s, t]) * map.density([s, t])
                    })
                }),
                Some(triangle) => {
                    // Parts with corners p₀ … pₙ as triangles about p₀, each from the unit square by (x, xy).
                    let part =
                        crate::geometry::parametrisation::clipped(&triangle.corners(), [[s[0], s[1]], [t[0], t[1]]]);
                    (1..part.len().saturating_sub(1))
                        .map(|k| {
                            let [a, b, c] = [part[0], part[k], part[k + 1]];
                            let twice = ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
                            gauss_10(0.5, 0.5, |x| {
                                gauss_10(0.5, 0.5, |y| {
                                    let at = [0, 1].map(|i| a[i] + x * (b[i] - a[i] + y * (c[i] - b[i])));
                                    x * twice * texels.at_map(at) * map.density(at)
                                })
                            })
                        })
                        .sum()
                }
            };
        }
    }
    total
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn the_integral_is_the_sum_over_texels(
        ns in 1..7_usize,
        nt in 1..7_usize,
        values in proptest::collection::vec(0.0..3.0, 49),
    ) {
        let grid = TexelGrid::new(ns, nt).unwrap();
        let raster = Raster::new(grid, values[..ns * nt].to_vec()).unwrap();
        for map in maps() {
            let direct: f64 = grid.texels().map(|texel| raster.value(texel) * map.texel_area(grid, texel)).sum();
            for lookup in [Lookup::Nearest, Lookup::Bilinear] {
                let texels = Texels::new(map, raster.clone(), lookup);
                let integral = by_quadrature(&texels);
                let tells = format!("{map:?} {lookup:?} {ns} × {nt}: {integral} against {direct}");
                prop_assert!((integral - direct).abs() <= 1e-12 * direct, "{}", tells);
                prop_assert!((texels.integral() - direct).abs() <= 1e-14 * direct, "{}", tells);
            }
        }
    }

    #[test]
    fn values_stay_within_the_stated_range(s in 0.0..1.0, t in 0.0..1.0, k in 0..5_usize) {
        let grid = TexelGrid::new(4, 3).unwrap();
        let raster = Raster::new(grid, (0..12).map(|k| f64::from(k * k % 7)).collect()).unwrap();
        let texels = Texels::new(maps()[k], raster, Lookup::Bilinear);
        let [low, high] = texels.range();
        let value = texels.at_map(covered(texels.map(), [s, t]));
        prop_assert!(value >= low - 1e-12 && value <= high + 1e-12, "{value}");
    }
}

#[test]
fn a_constant_stays_constant() {
    let grid = TexelGrid::new(5, 4).unwrap();
    for map in maps() {
        let texels = Texels::new(map, Raster::checker(grid, 1.25, 1.25).unwrap(), Lookup::Bilinear);
        for k in 0..400 {
            let at = covered(&map, [f64::from(k % 20) / 20.0 + 0.01, f64::from(k / 20) / 20.0 + 0.02]);
            approx::assert_relative_eq!(texels.at_map(at), 1.25, max_relative = 1e-13);
        }
    }
}

#[test]
fn what_is_blended_is_continuous_at_the_seam_and_at_the_poles() {
    let grid = TexelGrid::new(5, 4).unwrap();
    let raster = Raster::new(grid, (0..20).map(|k| f64::from(k * k % 11)).collect()).unwrap();
    let texels = Texels::new(maps()[2], raster.clone(), Lookup::Bilinear);
    for t in [0.1, 0.4, 0.77] {
        let (east, west) = (texels.at_map([0.0, t]), texels.at_map([1.0 - 1e-13, t]));
        assert!((east - west).abs() < 1e-10, "{east} against {west}");
    }
    for (t, row) in [(1e-9, 0), (1.0 - 1e-9, 3)] {
        let mean = raster.values()[row * 5..row * 5 + 5].iter().sum::<f64>() / 5.0;
        for s in [0.0, 0.3, 0.5, 0.9] {
            assert!((texels.at_map([s, t]) - mean).abs() < 1e-12, "{s} {t}");
        }
    }
}

#[test]
fn on_even_texels_blending_is_bilinear_interpolation() {
    let grid = TexelGrid::new(2, 2).unwrap();
    let raster = Raster::new(grid, vec![0.0, 1.0, 2.0, 5.0]).unwrap();
    let texels = Texels::new(maps()[0], raster, Lookup::Bilinear);
    let at = |s, t| texels.at_map([s, t]);
    assert_eq!(
        [at(0.25, 0.25), at(0.75, 0.25), at(0.5, 0.25), at(0.25, 0.5), at(0.5, 0.5)],
        [0.0, 1.0, 0.5, 1.0, 2.0]
    );
    assert_eq!(at(0.1, 0.1), 0.0, "constant beyond the middles of the outer texels");
    approx::assert_relative_eq!(at(0.625, 0.5), 0.25 * 1.0 + 0.75 * 3.0, epsilon = 1e-15);
}

#[test]
fn a_checker_on_a_rectangle_is_read_where_it_lies() {
    let rectangle = Rectangle::new(DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 2.0).unwrap();
    let raster = Raster::checker(TexelGrid::new(4, 2).unwrap(), 3.0, 1.0).unwrap();
    let texels = Texels::new(Parametrisation::rectangle(&rectangle), raster, Lookup::Nearest);
    let at = |x: f64, y: f64| texels.at(DVec3::new(x, y, 0.0));
    assert_eq!([at(-1.9, -0.9), at(-0.9, -0.9), at(-1.9, 0.1), at(1.9, 0.9)], [3.0, 1.0, 1.0, 3.0]);
    assert_eq!(texels.integral(), 16.0);
    assert_eq!(Texture::Texels(texels).mean(), 2.0);
}

#[test]
fn srgb_is_that_of_the_standard() {
    // IEC 61966-2-1: half of full scale is 21.4 % of the light; the curve's two parts meet.
    approx::assert_abs_diff_eq!(Encoding::Srgb.decode(0.5), 0.214_041_140_482_232_55, epsilon = 1e-15);
    assert_eq!(
        [Encoding::Srgb.decode(0.0), Encoding::Srgb.decode(1.0), Encoding::Linear.decode(0.5)],
        [0.0, 1.0, 0.5]
    );
    let join = 0.040_45;
    approx::assert_abs_diff_eq!(Encoding::Srgb.decode(join + 1e-15), join / 12.92, epsilon = 4e-8);
}

#[test]
fn impossible_values_are_refused() {
    let grid = TexelGrid::new(2, 1).unwrap();
    assert_eq!(Raster::new(grid, vec![1.0]), Err(TextureError::Length { said: 1, expected: 2 }));
    for bad in [-1.0, f64::INFINITY] {
        assert_eq!(Raster::new(grid, vec![1.0, bad]), Err(TextureError::Value { i: 1, j: 0, said: bad }));
    }
    let rectangle = Rectangle::new(DVec3::ZERO, DVec3::X, DVec3::Y).unwrap();
    // Least at the middle, and nowhere on the border.
    let bowl = ExitancePolynomial { e00: -0.1, e20: 4.0, e02: 4.0, ..Default::default() };
    assert_eq!(OnRectangle::new(rectangle, bowl), Err(TextureError::Negative { least: -0.1 }));
    let bowl = ExitancePolynomial { e00: 0.0, ..bowl };
    assert_eq!(OnRectangle::new(rectangle, bowl).map(|on| [on.least, on.largest]), Ok([0.0, 2.0]));
    let unlimited = ExitancePolynomial { e10: f64::NAN, ..bowl };
    assert!(matches!(OnRectangle::new(rectangle, unlimited), Err(TextureError::NotFinite { .. })));
}

#[test]
fn a_polynomial_on_a_tilted_rectangle_has_its_extremes_found() {
    let frame = Frame::around(DVec3::new(0.3, 0.2, 1.0).normalize());
    let rectangle = Rectangle::new(DVec3::ONE, frame.tangent * 1.4, frame.bitangent * 0.8).unwrap();
    let polynomial = ExitancePolynomial { e00: 2.0, e10: 0.7, e01: -0.4, e20: -1.0, e11: 0.9, e02: -2.0 };
    let [low, high] = polynomial.range(&rectangle);
    let map = Parametrisation::rectangle(&rectangle);
    let values = (0..=200).flat_map(|i| (0..=200).map(move |j| [f64::from(i) / 200.0, f64::from(j) / 200.0]));
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    for at in values {
        let value = polynomial.value_at(&rectangle, map.to_surface(at));
        (least, most) = (least.min(value), most.max(value));
    }
    assert!(low <= least + 1e-14 && least < low + 1e-3 && high >= most - 1e-14 && most > high - 1e-3);
}
