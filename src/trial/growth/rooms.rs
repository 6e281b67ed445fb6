//! The rooms whose cost is measured: a level square of 1 m, 2 m above the floor, and what stands before it.

use crate::configuration::{
    Arrangement, Configuration, Contents, Glass, GlassShape, Lamp, MeasurementPoint, Receiver, ReceiverShape, Source,
};
use crate::geometry::{DVec3, Disk, Mesh, Rectangle, Shape, Sphere};
use crate::radiometry::{Beam, Exitance, Irradiance};

const KNOWN: &str = "numbers written here, and checked by a test";
const HEIGHT: f64 = 2.0;

fn room(occluders: Vec<Shape>, points: Vec<MeasurementPoint>) -> Configuration {
    let square = Rectangle::new(DVec3::Z * HEIGHT, DVec3::Y, DVec3::X).expect(KNOWN);
    let source = Source::new(Shape::Rectangle(square), Exitance::new(1.0)).expect(KNOWN);
    Configuration::new(vec![source], occluders, None, points, Arrangement::Scattered).expect(KNOWN)
}

fn point(x: f64, y: f64) -> MeasurementPoint {
    MeasurementPoint::new(DVec3::new(x, y, 0.0), DVec3::Z).expect(KNOWN)
}

fn level_disk(x: f64, y: f64, radius: f64) -> Shape {
    Shape::Disk(Disk::new(DVec3::new(x, y, 0.5 * HEIGHT), -DVec3::Z, radius).expect(KNOWN))
}

/// One disk half way, and a grid of points with so many to a side within 0.3 m of (0.4, 0.1): the penumbra and beside it.
pub(super) fn behind_a_disk(side: u64) -> Configuration {
    let at = |k: u64| 0.6 * ((k as f64 + 0.5) / side as f64 - 0.5);
    let points = (0..side * side).map(|k| point(0.4 + at(k % side), 0.1 + at(k / side))).collect();
    room(vec![level_disk(0.0, 0.0, 0.3)], points)
}

/// So many small disks, at most 64, on a lattice that fills the pyramid from the point below the middle to the source. Those
/// of a smaller room are spread over the lattice: bits reversed, row and column by turns.
pub(super) fn behind_disks(n: u64) -> Configuration {
    let place = |k: u64| {
        let bit = |b: u64| (k >> b) & 1;
        let column = bit(0) * 4 + bit(2) * 2 + bit(4);
        let row = bit(1) * 4 + bit(3) * 2 + bit(5);
        let at = |i: u64| 0.48 * ((i as f64 + 0.5) / 8.0 - 0.5);
        level_disk(at(column), at(row), 0.02)
    };
    room((0..n.min(64)).map(place).collect(), vec![point(0.0, 0.0)])
}

/// A sheet of 1 m by 1 m half way up, waves of 5 cm on it, so many squares along a side: it covers x > 0.
pub(super) fn sheet(side: u64) -> Mesh {
    let across = side + 1;
    let wave = |t: f64| {
        let f = (3.0 * t).fract();
        4.0 * f * (1.0 - f)
    };
    let vertices = (0..across * across).map(|k| {
        let (u, v) = ((k % across) as f64 / side as f64, (k / across) as f64 / side as f64);
        DVec3::new(u, v - 0.5, 0.5 * HEIGHT + 0.05 * wave(u) * wave(v))
    });
    let triangles = (0..side * side).flat_map(|k| {
        let corner = (k / side) * across + k % side;
        let [a, b, c, d] = [corner, corner + 1, corner + across, corner + across + 1].map(|i| i as u32);
        [[a, b, d], [a, d, c]]
    });
    Mesh::new(vertices.collect(), triangles.collect()).expect(KNOWN)
}

/// A box around every shadow ray that passes a sheet.
pub(super) fn reach_of_sheet() -> (DVec3, DVec3) {
    (DVec3::new(-0.5, -0.5, 0.0), DVec3::new(0.5, 0.5, HEIGHT))
}

/// A sheet before half of the source, seen from 64 points.
pub(super) fn behind_a_sheet(mesh: Mesh) -> Configuration {
    let at = |k: u32| 0.5 * ((f64::from(k) + 0.5) / 8.0 - 0.5);
    room(vec![Shape::Mesh(mesh)], (0..64).map(|k| point(at(k % 8), at(k / 8))).collect())
}

/// A beam through a ball of glass onto a screen.
pub(super) fn ball_of_glass() -> Configuration {
    let beam = Beam::new(DVec3::Z * 3.0, -DVec3::Z, 0.8, Irradiance::new(1.0)).expect(KNOWN);
    let ball = GlassShape::Sphere(Sphere::new(DVec3::ZERO, 1.0).expect(KNOWN));
    let screen = Rectangle::new(DVec3::Z * -2.0, DVec3::X * 6.0, DVec3::Y * 6.0).expect(KNOWN);
    Configuration::of(Contents {
        lamps: vec![Lamp::Beam(beam)],
        glass: vec![Glass::new(ball, 1.5).expect(KNOWN)],
        receiver: Some(Receiver::new(ReceiverShape::Rectangle(screen), None).expect(KNOWN)),
        ..Contents::default()
    })
    .expect(KNOWN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::{Oracle, Region};

    #[test]
    fn every_room_is_valid_and_as_large_as_asked() {
        for side in [1, 2, 8] {
            assert_eq!(behind_a_disk(side).points().len() as u64, side * side);
            let sheet = sheet(side);
            assert_eq!(sheet.triangles().len() as u64, 2 * side * side);
            assert_eq!(behind_a_sheet(sheet).points().len(), 64);
        }
        assert_eq!(ball_of_glass().glass().len(), 1);
    }

    #[test]
    fn the_one_point_behind_a_disk_lies_in_its_penumbra() {
        let room = behind_a_disk(1);
        assert_eq!(Oracle::new(&room).at(&room.points()[0]).region, Region::Penumbra);
    }

    #[test]
    fn disks_are_apart_and_each_of_them_hides_some_of_the_source() {
        let shares: Vec<f64> = [1, 2, 4, 8, 16, 32, 64]
            .map(|n| {
                let room = behind_disks(n);
                assert_eq!(room.occluders().len() as u64, n);
                let truth = Oracle::new(&room).at(&room.points()[0]);
                1.0 - truth.irradiance.watts_per_square_metre() / truth.unoccluded_irradiance.watts_per_square_metre()
            })
            .to_vec();
        // Each hides about as much as another: twice the disks, twice the shadow.
        for pair in shares.windows(2) {
            assert!((1.8..2.2).contains(&(pair[1] / pair[0])), "{shares:?}");
        }
    }

    #[test]
    fn a_sheet_hides_about_half() {
        let room = behind_a_sheet(sheet(20));
        let oracle = Oracle::new(&room);
        let (mut seen, mut all) = (0.0, 0.0);
        for truth in room.points().iter().map(|point| oracle.at(point)) {
            seen += truth.irradiance.watts_per_square_metre();
            all += truth.unoccluded_irradiance.watts_per_square_metre();
        }
        assert!((0.3..0.7).contains(&(seen / all)), "{}", seen / all);
    }
}
