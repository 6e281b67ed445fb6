//! Light that takes a bend, against certified tables (`tests/data/reference`), row by row.

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::DVec3;
use etendue::oracle::optics::{
    Arrival, Caustic, CoaxialDisks, CylinderMirror, Loss, MirrorOracle, PlaneMirror, Which,
};
use etendue::radiometry::{Albedo, Exitance};

use crate::closed_forms::{Row, Table, agree};
use crate::exact;

/// Every row's value and number of rays.
fn check(table: &'static str, column: &'static str, caustic: impl Fn(&Row<'_>) -> Caustic) {
    let table_of = Table::read(table);
    let values = table_of.rows().map(|row| {
        let id = row.text("id").to_owned();
        let arrival = caustic(&row).at(row.number("rho")).unwrap();
        let Arrival::Finite { value, bound, n_rays } = arrival else { panic!("{id} has a value") };
        assert_eq!(n_rays as f64, row.number("preimages"), "{id}");
        let wanted = row.number(column);
        assert!(
            (value - wanted).abs() <= bound + f64::EPSILON * wanted,
            "{id}: {value:e}, {wanted:e} within {bound:e}"
        );
        (id, value, wanted)
    });
    agree(table, 1e-14, values);
}

#[test]
fn caustic_paraboloid() {
    check("caustic_paraboloid", "E_over_E0", |row| {
        Caustic::paraboloid(row.number("f"), row.number("zp"), row.number("beam_radius")).unwrap()
    });
}

#[test]
fn caustic_spherical_mirror() {
    check("caustic_spherical_mirror", "E_over_E0", |row| {
        Caustic::spherical_mirror(row.number("R"), row.number("zp"), row.number("beam_radius")).unwrap()
    });
}

#[test]
fn caustic_ball_lens() {
    let columns = [
        ("E_fresnel_per_polarisation", Loss::PerPolarisation),
        ("E_fresnel_unpolarised_each_face", Loss::EachFaceUnpolarised),
        ("E_lossless", Loss::None),
    ];
    for (column, loss) in columns {
        check("caustic_ball_lens", column, |row| {
            let [radius, index, distance, beam] = ["R", "n", "q", "beam_radius"].map(|name| row.number(name));
            Caustic::glass_ball(radius, index, distance, beam, loss).unwrap()
        });
    }
}

#[test]
fn caustic_plano_convex() {
    check("caustic_plano_convex", "E_over_E0", |row| {
        let [radius, index, distance, beam] = ["R", "n", "q", "beam_radius"].map(|name| row.number(name));
        Caustic::plano_convex(radius, index, distance, beam, Loss::PerPolarisation).unwrap()
    });
}

#[test]
fn caustic_slab_point_source() {
    check("caustic_slab_point_source", "E_over_I", |row| {
        let [air, glass, index] = ["h_air", "d_glass", "n"].map(|name| row.number(name));
        Caustic::slab_under_point_source(air, glass, index, 0, Loss::PerPolarisation).unwrap()
    });
}

#[test]
fn caustic_bins() {
    let table = Table::read("caustic_bins");
    let values = table.rows().flat_map(|row| {
        let [radius, index, plane, beam] = ["R", "n", "zp_or_q", "beam_radius"].map(|name| row.number(name));
        let caustic = match row.text("kind") {
            "sphere_mirror" => Caustic::spherical_mirror(radius, plane, beam),
            "ball_lens" => Caustic::glass_ball(radius, index, plane, beam, Loss::PerPolarisation),
            other => panic!("unknown layout {other}"),
        }
        .unwrap();
        let ring = caustic.power_in_ring(row.number("rho0"), row.number("rho1")).unwrap();
        let id = row.text("id");
        [
            (format!("{id} ring"), ring.value, row.number("power_in_ring_over_E0")),
            (format!("{id} total"), caustic.total().value, row.number("power_total_over_E0")),
        ]
    });
    agree("caustic_bins", 1e-13, values);
}

#[test]
fn caustic_nephroid() {
    let table = Table::read("caustic_nephroid");
    let values = table.rows().map(|row| {
        let id = row.text("id").to_owned();
        let cup = CylinderMirror::new(row.number("R"), f64::INFINITY).unwrap();
        let arrival = cup.at(row.number("x"), row.number("y")).unwrap();
        let Arrival::Finite { value, bound, n_rays } = arrival else { panic!("{id} has a value") };
        assert_eq!(n_rays as f64, row.number("preimages"), "{id}");
        let wanted = row.number("E_over_Edirect");
        assert!(
            (value - wanted).abs() <= bound + f64::EPSILON * wanted,
            "{id}: {value:e}, {wanted:e} within {bound:e}"
        );
        (id, value, wanted)
    });
    agree("caustic_nephroid", 1e-14, values);
}

#[test]
fn interreflection_disks() {
    let table = Table::read("interreflection_disks");
    let values = table.rows().flat_map(|row| {
        let albedos = ["rho1", "rho2"].map(|name| Albedo::new(row.number(name)));
        let radii = ["R1", "R2"].map(|name| row.number(name));
        let disks =
            CoaxialDisks::new(row.number("h"), radii, albedos, [Exitance::new(0.0), Exitance::new(1.0)]).unwrap();
        let (r1, r2) = (row.number("r1"), row.number("r2"));
        let found = [
            ("B2_one_bounce", disks.reflected_after(Which::Second, r2, 2).unwrap()),
            ("B1_full", disks.radiosity(Which::First, r1).unwrap()),
            ("B2_full", disks.radiosity(Which::Second, r2).unwrap()),
        ];
        found.map(|(column, found)| {
            let (id, wanted) = (format!("{} {column}", row.text("id")), row.number(column));
            assert!(
                (found.value - wanted).abs() <= found.bound + f64::EPSILON * wanted,
                "{id}: {found:?}, {wanted:e}"
            );
            (id, found.value, wanted)
        })
    });
    agree("interreflection_disks", 1e-14, values);
}

#[test]
fn mirror_window() {
    let table = Table::read("mirror_window");
    let values = table.rows().map(|row| {
        let vector = |names: [&str; 3]| DVec3::from_array(names.map(|name| row.number(name)));
        let point = MeasurementPoint::new(vector(["rx", "ry", "rz"]), vector(["nx", "ny", "nz"])).unwrap();
        let source = Source::new(exact::shape(row.text("source")), Exitance::new(1.0)).unwrap();
        let room = Configuration::new(vec![source], vec![], None, vec![point], Arrangement::Scattered).unwrap();
        let mirror = PlaneMirror::new(exact::shape(row.text("mirror")), 1.0).unwrap();
        let found = MirrorOracle::new(&room, &mirror).unwrap().at(&point).unwrap();
        let (id, wanted) = (row.text("id").to_owned(), row.number("F_mirror"));
        let (value, bound) = (found.form_factor.ratio(), found.bound.watts_per_square_metre());
        assert!(
            (value - wanted).abs() <= bound + f64::EPSILON * wanted,
            "{id}: {value:e}, {wanted:e} within {bound:e}"
        );
        (id, value, wanted)
    });
    agree("mirror_window", 1e-12, values);
}
