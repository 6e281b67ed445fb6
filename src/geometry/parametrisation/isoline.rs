//! The curves on a surface along which s, or t, is one number.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

use super::{Chart, Parametrisation};

/// A curve on a surface, by offsets from the [anchor](Parametrisation::anchor) of its map, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Isoline {
    /// From one point to another.
    Segment([DVec3; 2]),
    /// A whole circle, and its unit normal.
    Circle { center: DVec3, normal: DVec3, radius: f64 },
}

impl Parametrisation {
    /// Where s has one value; `None` where no part of the surface has it.
    ///
    /// On a disk it comes with where s is half a turn more: a diameter; on a sphere likewise: a whole great circle.
    pub fn line_of_s(&self, s: f64) -> Option<Isoline> {
        match &self.chart {
            Chart::Rectangle(plane) => Some(Isoline::Segment([plane.offset(s, 0.0), plane.offset(s, 1.0)])),
            Chart::Triangle { .. } => self.across_triangle(0, s),
            Chart::Disk { zero, quarter, radius, .. } => {
                let (sin, cos) = libm::sincos(TAU * s);
                let way = (*zero * cos + *quarter * sin) * *radius;
                Some(Isoline::Segment([-way, way]))
            }
            Chart::Sphere { equator, east, radius, .. } => {
                let (sin, cos) = libm::sincos(TAU * s);
                Some(Isoline::Circle { center: DVec3::ZERO, normal: *east * cos - *equator * sin, radius: *radius })
            }
        }
    }

    /// Where t has one value; `None` where no more than a point of the surface has it.
    pub fn line_of_t(&self, t: f64) -> Option<Isoline> {
        match &self.chart {
            Chart::Rectangle(plane) => Some(Isoline::Segment([plane.offset(0.0, t), plane.offset(1.0, t)])),
            Chart::Triangle { .. } => self.across_triangle(1, t),
            Chart::Disk { zero, quarter, radius, .. } => {
                let circle =
                    Isoline::Circle { center: DVec3::ZERO, normal: zero.cross(*quarter), radius: radius * t.sqrt() };
                (t > 0.0).then_some(circle)
            }
            Chart::Sphere { north, radius, .. } => {
                let (sin, cos) = libm::sincos(PI * t);
                let circle =
                    Isoline::Circle { center: -*north * (cos * radius), normal: *north, radius: radius * sin };
                (t > 0.0 && t < 1.0).then_some(circle)
            }
        }
    }

    /// The part of a line of the map, `axis` being `level` on it, that lies in the map's triangle.
    fn across_triangle(&self, axis: usize, level: f64) -> Option<Isoline> {
        let corners = self.map_triangle()?.corners();
        let crossing = |k: usize| {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let share = (level - p[axis]) / (q[axis] - p[axis]);
            (0.0..=1.0).contains(&share).then(|| [0, 1].map(|i| p[i] + share * (q[i] - p[i])))
        };
        let along = 1 - axis;
        let crossings: Vec<[f64; 2]> = (0..3).filter_map(crossing).collect();
        let low = crossings.iter().copied().min_by(|a, b| a[along].total_cmp(&b[along]))?;
        let high = crossings.iter().copied().max_by(|a, b| a[along].total_cmp(&b[along]))?;
        (low != high).then(|| Isoline::Segment([self.offset(low), self.offset(high)]))
    }
}
