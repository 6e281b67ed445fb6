//! The exact side against certified tables (`tests/data/reference`), row by row.

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Polygon, Shape, Sphere};
use etendue::oracle::{Oracle, Region, Truth};
use etendue::radiometry::Exitance;

use crate::closed_forms::{self, Table};

pub struct Row {
    pub id: String,
    pub unoccluded: f64,
    pub visible: f64,
    pub configuration: Configuration,
    pub oracle: Oracle,
    pub point: MeasurementPoint,
    /// Whether the row names occluders.
    is_occluded: bool,
    truth: Truth,
    /// Whether the horizon cuts the source.
    is_cut: bool,
}

pub fn shape(text: &str) -> Shape {
    let mut words = text.split_whitespace();
    let kind = words.next().expect("a kind");
    let numbers: Vec<f64> = words.map(|w| w.parse().expect("a number")).collect();
    let vector = |i: usize| DVec3::new(numbers[i], numbers[i + 1], numbers[i + 2]);
    match kind {
        "disk" => Shape::Disk(Disk::new(vector(0), vector(3), numbers[6]).unwrap()),
        "ball" => Shape::Sphere(Sphere::new(vector(0), numbers[3]).unwrap()),
        "poly" => {
            Shape::Polygon(Polygon::new((0..numbers[0] as usize).map(|i| vector(1 + 3 * i)).collect()).unwrap())
        }
        other => panic!("unknown surface {other}"),
    }
}

/// Whether a source reaches below the receiver's horizon, told from the shape alone.
fn sinks(source: &Shape, x: DVec3, n: DVec3) -> bool {
    let lowest = match source {
        Shape::Disk(d) => n.dot(d.center() - x) - d.radius() * n.cross(d.normal()).length(),
        Shape::Sphere(s) => n.dot(s.center() - x) - s.radius(),
        Shape::Polygon(p) => p.vertices().iter().map(|v| n.dot(*v - x)).fold(f64::INFINITY, f64::min),
        _ => unreachable!("no such row"),
    };
    lowest < 0.0
}

pub fn rows(table: &'static str) -> Vec<Row> {
    let rows: Vec<Row> = Table::read(table).rows().map(|row| read(&row)).collect();
    assert!(rows.len() > 10, "{table} is nearly empty");
    rows
}

fn read(row: &closed_forms::Row) -> Row {
    let vector = |names: [&str; 3]| DVec3::from_array(names.map(|name| row.number(name)));
    let x = vector(["rx", "ry", "rz"]);
    let point = MeasurementPoint::new(x, vector(["nx", "ny", "nz"])).unwrap();
    let source = shape(row.text("source"));
    let is_cut = sinks(&source, x, point.normal());
    let occluders: Vec<Shape> =
        row.text("occluders").split(';').filter(|s| !s.trim().is_empty()).map(shape).collect();
    let is_occluded = !occluders.is_empty();
    let source = Source::new(source, Exitance::new(1.0)).unwrap();
    let configuration =
        Configuration::new(vec![source], occluders, None, vec![point], Arrangement::Scattered).unwrap();
    let oracle = Oracle::new(&configuration);
    Row {
        id: row.text("id").to_owned(),
        unoccluded: row.number("F_unoccluded"),
        visible: row.number("F"),
        is_occluded,
        truth: oracle.at(&point),
        oracle,
        configuration,
        point,
        is_cut,
    }
}

/// Every row of a table: within its own bound, and within what is promised of its kind.
///
/// - `relative`: of unoccluded sources wholly above the horizon
fn check(table: &'static str, relative: f64) {
    let mut faults = Vec::new();
    let (mut worst, mut worst_share, mut worst_bound) = ((0.0, String::new()), (0.0, String::new()), 0.0_f64);
    let rows = rows(table);
    for row in &rows {
        let f = row.truth.form_factor.ratio();
        let bound = row.truth.bound.watts_per_square_metre();
        let error = (f - row.visible).abs();
        let promised =
            if !row.is_occluded && !row.is_cut { relative * row.visible } else { 1e-12 * row.unoccluded + 2e-15 };
        // The table's value is itself rounded to f64 here.
        let own = bound + f64::EPSILON * row.visible;
        if error > promised || error > own || bound.is_nan() {
            faults.push(format!(
                "{}: F = {f:e}, expected {:e}, error {error:.1e}, promised {promised:.1e}, bound {bound:.1e}, {}",
                row.id, row.visible, row.truth.region
            ));
        }
        let scaled = error / row.unoccluded.max(1e-300);
        if scaled > worst.0 {
            worst = (scaled, row.id.clone());
        }
        if error / own.max(1e-300) > worst_share.0 {
            worst_share = (error / own.max(1e-300), row.id.clone());
        }
        if row.unoccluded > 0.0 {
            worst_bound = worst_bound.max(bound / row.unoccluded);
        }
        assert_eq!(
            row.truth.region == Region::Umbra || row.truth.region == Region::BelowHorizon,
            f == 0.0,
            "{}",
            row.id
        );
        let unoccluded = row.truth.unoccluded_irradiance.watts_per_square_metre();
        let error = (unoccluded - row.unoccluded).abs();
        if error > 1e-12 * row.unoccluded + 2e-15 {
            faults.push(format!("{}: unoccluded {unoccluded:e}, expected {:e}", row.id, row.unoccluded));
        }
    }
    println!(
        "{table}: {} rows; worst error / F_unoccluded {:.1e} ({}); worst error / bound {:.2} ({}); largest bound / F_unoccluded {worst_bound:.1e}",
        rows.len(),
        worst.0,
        worst.1,
        worst_share.0,
        worst_share.1
    );
    assert!(faults.is_empty(), "{} of {} rows:\n{}", faults.len(), rows.len(), faults.join("\n"));
}

macro_rules! tables {
    ($($name:ident: $relative:expr;)*) => {
        $(#[test]
        fn $name() {
            check(stringify!($name), $relative);
        })*
    };
}

tables! {
    point_disk: 1e-14;
    point_sphere: 1e-14;
    point_polygon: 1e-12;
    foreshortening: 1e-12;
    occ_ball: 1e-14;
    occ_disk_disk: 1e-14;
    occ_disk_disk_parallel: 1e-14;
    occ_disk_poly: 1e-14;
    occ_multi: 1e-12;
    occ_nonconvex_poly: 1e-12;
    occ_poly_disk: 1e-12;
    occ_poly_poly: 1e-12;
    occ_sphere_source: 1e-14;
}
