//! Stand-alone closed forms against certified tables (`tests/data/reference`), row by row.

use std::path::Path;

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Rectangle, Shape, Sphere, solid_angle};
use etendue::oracle::limits::{LimitMethod, limits};
use etendue::oracle::patch;
use etendue::radiometry::{
    Albedo, Exitance, Fresnel, Intensity, enclosure, mean_reflectance_from_inside, mean_reflectance_from_outside,
};

/// A table: what each row is called, what it gives, and what it wants.
pub struct Table {
    name: &'static str,
    header: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
}

impl Table {
    pub fn read(name: &'static str) -> Table {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference").join(name).with_extension("csv");
        let mut reader = csv::Reader::from_path(&path).unwrap();
        let header = reader.headers().unwrap().clone();
        Table { name, header, rows: reader.records().map(Result::unwrap).collect() }
    }

    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|record| Row { table: self, record })
    }
}

pub struct Row<'a> {
    table: &'a Table,
    record: &'a csv::StringRecord,
}

impl<'a> Row<'a> {
    pub fn text(&self, column: &str) -> &'a str {
        let at = self.table.header.iter().position(|name| name == column);
        &self.record[at.unwrap_or_else(|| panic!("{} has no column {column}", self.table.name))]
    }
    pub fn number(&self, column: &str) -> f64 {
        self.text(column).parse().expect("a number")
    }
    pub fn numbers(&self, column: &str) -> Vec<f64> {
        self.text(column).split_whitespace().map(|word| word.parse().expect("a number")).collect()
    }
}

/// What was found and what the table says, with the row's name; the largest relative error is printed.
pub fn agree(table: &str, relative: f64, values: impl IntoIterator<Item = (String, f64, f64)>) {
    let (mut worst, mut faults, mut count) = ((0.0, String::new()), Vec::new(), 0);
    for (name, found, wanted) in values {
        count += 1;
        let error = if wanted == 0.0 { found.abs() } else { ((found - wanted) / wanted).abs() };
        if error.is_nan() || error > relative {
            faults.push(format!("{name}: {found:e}, expected {wanted:e}, relative error {error:.1e}"));
        }
        if error > worst.0 {
            worst = (error, name);
        }
    }
    println!("{table}: {count} values; worst relative error {:.1e} ({})", worst.0, worst.1);
    assert!(count >= 8, "{table}: only {count} values");
    assert!(faults.is_empty(), "{} of {count} values:\n{}", faults.len(), faults.join("\n"));
}

#[test]
fn patch_patch() {
    let table = Table::read("patch_patch");
    let values = table.rows().map(|row| {
        let given = row.numbers("params");
        let [a, b, c] = given[..] else { panic!("three lengths") };
        let found = match row.text("kind") {
            "coaxial_disks_h_r1_r2" => patch::disk_to_disk(b, c, a),
            "parallel_rects_a_b_c" => patch::rectangle_to_opposite_rectangle(a, b, c),
            "perp_rects_h_w_l" => patch::rectangle_to_adjoining_rectangle(b, a, c),
            other => panic!("unknown pair {other}"),
        };
        (row.text("id").to_owned(), found.unwrap().ratio(), row.number("F12"))
    });
    agree("patch_patch", 1e-14, values);
}

#[test]
fn solid_angles() {
    let table = Table::read("solid_angle");
    let values = table.rows().map(|row| {
        let g = row.numbers("params");
        let vector = |i: usize| DVec3::new(g[i], g[i + 1], g[i + 2]);
        let eye = DVec3::ZERO;
        let found = match row.text("kind") {
            "disk" => {
                let disk = Disk::new(DVec3::new(g[0], 0.0, g[1]), DVec3::Z, g[2]).unwrap();
                solid_angle::disk(eye, &disk)
            }
            "rect_corner" => {
                let center = DVec3::new(0.5 * g[0], 0.5 * g[1], g[2]);
                let rectangle = Rectangle::new(center, DVec3::X * g[0], DVec3::Y * g[1]).unwrap();
                let (placed, corner) =
                    (solid_angle::rectangle(eye, &rectangle), solid_angle::rectangle_over_corner(g[0], g[1], g[2]));
                let ratio = placed.as_ref().unwrap() / corner.unwrap();
                assert!((ratio - 1.0).abs() < 1e-14, "{}: {ratio}", row.text("id"));
                placed
            }
            "sphere" => solid_angle::sphere(eye, &Sphere::new(DVec3::X * g[0], g[1]).unwrap()),
            "triangle" => solid_angle::triangle(eye, [vector(0), vector(3), vector(6)]),
            other => panic!("unknown shape {other}"),
        };
        (row.text("id").to_owned(), found.unwrap(), row.number("omega"))
    });
    agree("solid_angle", 1e-14, values);
}

#[test]
fn fresnel() {
    let table = Table::read("fresnel");
    let values = table.rows().flat_map(|row| {
        let face = Fresnel::at(row.number("n_t_over_n_i"), row.number("cos_i")).unwrap();
        let id = row.text("id");
        [
            (format!("{id} s"), face.reflectance_s, row.number("R_s")),
            (format!("{id} p"), face.reflectance_p, row.number("R_p")),
            (format!("{id} mean"), face.reflectance(), row.number("R_unpolarised")),
            (format!("{id} through"), face.transmittance() + face.reflectance(), 1.0),
        ]
    });
    agree("fresnel", 1e-14, values);
}

#[test]
fn fresnel_diffuse_mean() {
    let table = Table::read("fresnel_diffuse_mean");
    let values = table.rows().flat_map(|row| {
        let (n, id) = (row.number("n"), row.text("id"));
        [
            (format!("{id} outside"), mean_reflectance_from_outside(n).unwrap(), row.number("R_external")),
            (format!("{id} inside"), mean_reflectance_from_inside(n).unwrap(), row.number("R_internal")),
        ]
    });
    agree("fresnel_diffuse_mean", 1e-14, values);
}

#[test]
fn sphere_interior() {
    let table = Table::read("sphere_interior");
    let values = table.rows().flat_map(|row| {
        let (radius, albedo, light) = (row.number("R"), Albedo::new(row.number("rho")), row.number("E0_or_I"));
        let (indirect, second) = match row.text("kind") {
            "cap_emitter" => {
                let height = row.number("cap_height");
                let cap = enclosure::cap_that_emits_inside_sphere(radius, albedo, Exitance::new(light), height);
                let cap = cap.unwrap();
                (cap.reflected, cap.in_cap.watts_per_square_metre())
            }
            "point_light_offset" => {
                let offset = row.number("offset");
                let lit = enclosure::point_source_inside_sphere(Intensity::new(light), offset, radius, albedo);
                let lit = lit.unwrap();
                (lit.after_first_bounce, lit.mean_irradiance.watts_per_square_metre())
            }
            other => panic!("unknown light {other}"),
        };
        let id = row.text("id");
        [
            (format!("{id} indirect"), indirect.watts_per_square_metre(), row.number("B_indirect")),
            (format!("{id} second"), second, row.number("B_in_cap_or_mean_irradiance")),
        ]
    });
    agree("sphere_interior", 1e-14, values);
}

/// Where the core and the penumbra of an eclipse end, along a line from the axis outwards and along a chord.
#[test]
fn eclipse_radii() {
    let table = Table::read("eclipse_radii");
    let values = table.rows().flat_map(|row| {
        let [a, b, high, low] = ["a", "b", "H", "z"].map(|column| row.number(column));
        let (core, penumbra) = (row.number("core_radius"), row.number("penumbra_radius"));
        let disk = |z: f64, radius: f64| Shape::Disk(Disk::new(DVec3::Z * z, DVec3::NEG_Z, radius).unwrap());
        let source = Source::new(disk(high, a), Exitance::new(1.0)).unwrap();
        let id = row.text("id");
        let along = |from: f64, aside: f64| {
            let ends =
                [from, 1.5 * penumbra].map(|x| MeasurementPoint::new(DVec3::new(x, aside, 0.0), DVec3::Z).unwrap());
            let room =
                Configuration::new(vec![source.clone()], vec![disk(low, b)], None, ends.to_vec(), Arrangement::Line);
            limits(&room.unwrap()).unwrap()
        };
        let found = along(0.0, 0.0);
        let names: Vec<&str> = found.iter().map(|limit| limit.name()).collect();
        match row.text("core") {
            "umbra" => assert_eq!(names, ["umbra_ends", "penumbra_ends"], "{id}"),
            "antumbra" => assert_eq!(names, ["antumbra_ends", "penumbra_ends"], "{id}"),
            "apex" => assert_eq!(names, ["penumbra_ends"], "{id}"),
            other => panic!("unknown core {other}"),
        }
        assert!(found.iter().all(|limit| limit.method == LimitMethod::ClosedForm), "{id}");
        for limit in &found {
            assert!(limit.bound <= 1e-12 * (1.0 + penumbra), "{id}: {limit:?}");
        }
        // A chord at half the penumbra's radius meets it at √3/2 of it on either side.
        let chord = along(-1.5 * penumbra, 0.5 * penumbra);
        let [first, last] = [chord[0].position.x, chord[chord.len() - 1].position.x];
        let half = 0.75_f64.sqrt() * penumbra;
        let mut values = vec![
            (format!("{id} penumbra"), found[found.len() - 1].distance, penumbra),
            (format!("{id} chord begins"), first, -half),
            (format!("{id} chord ends"), last, half),
        ];
        if core > 0.0 {
            values.push((format!("{id} core"), found[0].distance, core));
        }
        values
    });
    agree("eclipse_radii", 1e-14, values);
}
