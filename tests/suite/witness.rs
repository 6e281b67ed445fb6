//! The second witness against certified tables and against itself.

use etendue::geometry::DVec3;
use etendue::oracle::{Method, Region};

use crate::exact::{Row, rows};

/// Every row by strips: within its own bound, and within 1e-10 of the unoccluded form factor.
fn check(table: &str) {
    let mut faults = Vec::new();
    let (mut worst, mut worst_bound, mut worst_share) = ((0.0, ""), (0.0, ""), (0.0, ""));
    let rows: Vec<Row> = rows(table);
    for row in &rows {
        let truth = row.oracle.by_quadrature(&row.point);
        assert_eq!(truth.method, Method::Quadrature);
        let f = truth.form_factor.ratio();
        let bound = truth.bound.watts_per_square_metre();
        let error = (f - row.visible).abs();
        // The table's value is itself rounded to f64 here.
        let own = bound + f64::EPSILON * row.visible;
        let whole = truth.unoccluded_irradiance.watts_per_square_metre();
        let whole_error = (whole - row.unoccluded).abs();
        let promised = 1e-10 * row.unoccluded + 1e-300;
        if [error, bound, whole_error].iter().any(|x| x.is_nan() || *x > promised) || error > own {
            faults.push(format!(
                "{}: F = {f:e}, expected {:e} of {:e}, error {error:.1e}, bound {bound:.1e}; unoccluded off by {whole_error:.1e}",
                row.id, row.visible, row.unoccluded
            ));
        }
        let dark = matches!(truth.region, Region::Umbra | Region::BelowHorizon);
        if dark != (row.visible == 0.0) {
            faults.push(format!("{}: {} where F = {:e}", row.id, truth.region, row.visible));
        }
        let scale = row.unoccluded.max(1e-300);
        for (most, now) in [
            (&mut worst, error / scale),
            (&mut worst_bound, bound / scale),
            (&mut worst_share, error / own.max(1e-300)),
        ] {
            if now > most.0 {
                *most = (now, row.id.as_str());
            }
        }
    }
    println!(
        "{table}: {} rows; of F_unoccluded: worst error {:.1e} ({}), largest bound {:.1e} ({}); worst error / bound {:.2} ({})",
        rows.len(),
        worst.0,
        worst.1,
        worst_bound.0,
        worst_bound.1,
        worst_share.0,
        worst_share.1
    );
    assert!(faults.is_empty(), "{} of {} rows:\n{}", faults.len(), rows.len(), faults.join("\n"));
}

macro_rules! tables {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            check(stringify!($name));
        })*
    };
}

tables! {
    point_disk
    point_sphere
    point_polygon
    foreshortening
    occ_ball
    occ_disk_disk
    occ_disk_disk_parallel
    occ_disk_poly
    occ_multi
    occ_nonconvex_poly
    occ_poly_disk
    occ_poly_poly
    occ_sphere_source
}

/// Every row of a table once more with an exitance that is asked for point by point.
#[test]
fn a_constant_exitance_is_the_uniform_value() {
    for table in ["occ_multi", "occ_sphere_source", "occ_nonconvex_poly"] {
        for row in rows(table).iter().step_by(3) {
            let textured = row.oracle.by_quadrature_with(&row.point, &|source, position: DVec3| {
                assert!(source == 0 && position.is_finite());
                2.5
            });
            let (value, bound) =
                (textured.irradiance.watts_per_square_metre(), textured.bound.watts_per_square_metre());
            let error = (value - 2.5 * row.visible).abs();
            assert!(
                bound < 1e-10 * row.unoccluded && error <= bound + 1e-300,
                "{}: {value:e}, error {error:.1e}, bound {bound:.1e}",
                row.id
            );
        }
    }
}
