//! A patch of a surface, and how its points are laid out for quadrature.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use crate::geometry::{Disk, Frame, Polygon, Rectangle, Shape, Triangle};

/// A flat surface that receives (and, as a source, emits) on the side of its normal.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Patch {
    /// A disk.
    Disk(Disk),
    /// A rectangle.
    Rectangle(Rectangle),
    /// A triangle.
    Triangle(Triangle),
    /// A simple polygon, convex or not.
    Polygon(Polygon),
}

impl Patch {
    /// The same surface as a source or an occluder.
    pub fn shape(&self) -> Shape {
        match self {
            Patch::Disk(disk) => Shape::Disk(*disk),
            Patch::Rectangle(rectangle) => Shape::Rectangle(*rectangle),
            Patch::Triangle(triangle) => {
                let polygon = Polygon::new(triangle.vertices().to_vec());
                Shape::Polygon(polygon.expect("a triangle was checked as a polygon when it was made"))
            }
            Patch::Polygon(polygon) => Shape::Polygon(polygon.clone()),
        }
    }
    /// Unit vector towards the receiving side.
    pub fn normal(&self) -> DVec3 {
        match self {
            Patch::Disk(disk) => disk.normal(),
            Patch::Rectangle(rectangle) => rectangle.normal(),
            Patch::Triangle(triangle) => triangle.normal(),
            Patch::Polygon(polygon) => polygon.normal(),
        }
    }
    /// Square metres.
    pub fn area(&self) -> f64 {
        self.shape().area()
    }

    pub(super) fn layout(&self) -> Layout {
        match self {
            Patch::Disk(disk) => {
                let frame = Frame::around(disk.normal());
                let band = Band { from: -FRAC_PI_2, to: FRAC_PI_2, spans: Vec::new() };
                Layout {
                    origin: disk.center(),
                    across: frame.tangent,
                    along: frame.bitangent,
                    circle: Some(disk.radius()),
                    bands: vec![band],
                }
            }
            Patch::Rectangle(rectangle) => Layout::of_outline(&rectangle.corners(), rectangle.normal()),
            Patch::Triangle(triangle) => Layout::of_outline(&triangle.vertices(), triangle.normal()),
            Patch::Polygon(polygon) => Layout::of_outline(polygon.vertices(), polygon.normal()),
        }
    }
}

/// A patch as strips: points are `origin + s across + t along`, and for each s of a band, t runs over one or more spans.
///
/// On a disk of radius R the strips are laid out by an angle θ: s = R sin θ, |t| ≤ R cos θ, so that nothing is singular at
/// the rim.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    origin: DVec3,
    across: DVec3,
    along: DVec3,
    circle: Option<f64>,
    pub bands: Vec<Band>,
}

#[derive(Clone, Debug)]
pub(super) struct Band {
    pub from: f64,
    pub to: f64,
    /// Pairs of edges, each as its two ends (s, t).
    spans: Vec<[Edge; 2]>,
}

type Edge = [[f64; 2]; 2];

impl Layout {
    /// Strips parallel to the longest edge; bands between the corners' s.
    fn of_outline(corners: &[DVec3], normal: DVec3) -> Layout {
        let next = |i: usize| corners[(i + 1) % corners.len()];
        let edges = (0..corners.len()).map(|i| next(i) - corners[i]);
        let longest = edges.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
        let along = longest.unwrap_or(DVec3::X).normalize();
        let across = along.cross(normal).normalize();
        let origin = corners[0];
        let flat = |corner: DVec3| [(corner - origin).dot(across), (corner - origin).dot(along)];
        let outline: Vec<[f64; 2]> = corners.iter().map(|corner| flat(*corner)).collect();
        let mut ends: Vec<f64> = outline.iter().map(|p| p[0]).collect();
        ends.sort_by(f64::total_cmp);
        let size = outline.iter().flatten().map(|x| x.abs()).fold(0.0, f64::max);
        // Corners on one strip but for rounding are one end.
        ends.dedup_by(|b, a| *b - *a <= 64.0 * f64::EPSILON * size);
        let band = |pair: &[f64]| {
            let middle = 0.5 * (pair[0] + pair[1]);
            let mut met: Vec<Edge> = (0..outline.len())
                .map(|i| [outline[i], outline[(i + 1) % outline.len()]])
                .filter(|[a, b]| (a[0] > middle) != (b[0] > middle))
                .collect();
            met.sort_by(|a, b| on_edge(*a, middle).total_cmp(&on_edge(*b, middle)));
            let spans = met.chunks_exact(2).map(|two| [two[0], two[1]]).collect();
            Band { from: pair[0], to: pair[1], spans }
        };
        let bands = ends.windows(2).map(band).collect();
        Layout { origin, across, along, circle: None, bands }
    }

    /// What one unit of a band's variable is worth in s, the strip's s, and its spans of t.
    pub fn strip(&self, band: &Band, variable: f64) -> (f64, f64, Vec<[f64; 2]>) {
        match self.circle {
            Some(radius) => {
                let (sin, cos) = variable.sin_cos();
                (radius * cos, radius * sin, vec![[-radius * cos, radius * cos]])
            }
            None => {
                let spans = band.spans.iter().map(|[low, high]| [on_edge(*low, variable), on_edge(*high, variable)]);
                (1.0, variable, spans.collect())
            }
        }
    }

    /// How far a point may be from where it should be, metres: its coordinates are rounded.
    pub fn blur(&self) -> f64 {
        2.0 * f64::EPSILON * self.origin.abs().max_element()
    }

    pub fn point(&self, s: f64, t: f64) -> DVec3 {
        self.origin + self.across * s + self.along * t
    }
}

/// Where an edge crosses the strip at s.
fn on_edge([a, b]: Edge, s: f64) -> f64 {
    a[1] + (b[1] - a[1]) * ((s - a[0]) / (b[0] - a[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The strips' lengths add up to the area, concave outlines and disks included; the points lie in the plane.
    #[test]
    fn strips_fill_the_patch() {
        let l = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let frame = Frame::around(DVec3::new(0.3, -0.5, 0.8).normalize());
        let place = |p: [f64; 2]| DVec3::ONE + frame.tangent * p[0] + frame.bitangent * p[1];
        let comb = [[0.0, 0.0], [3.0, 0.0], [2.5, 2.0], [2.0, 0.5], [1.0, 1.5], [0.5, 0.5], [0.2, 1.0]];
        let patches = [
            Patch::Polygon(Polygon::new(l.map(place).to_vec()).unwrap()),
            Patch::Polygon(Polygon::new(comb.map(place).to_vec()).unwrap()),
            Patch::Triangle(Triangle::new([[0.0, 0.0], [1.0, 0.2], [0.3, 2.0]].map(place)).unwrap()),
            Patch::Rectangle(Rectangle::new(DVec3::ONE, DVec3::X * 2.0, DVec3::Z * 0.1).unwrap()),
            Patch::Disk(Disk::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap()),
        ];
        for patch in patches {
            let layout = patch.layout();
            let mut area = 0.0;
            for band in &layout.bands {
                let n = 1000;
                let step = (band.to - band.from) / f64::from(n);
                for i in 0..n {
                    let (stretch, s, spans) = layout.strip(band, band.from + step * (f64::from(i) + 0.5));
                    for [from, to] in spans {
                        assert!(to >= from);
                        area += stretch * step * (to - from);
                        let off = (layout.point(s, from) - layout.point(0.0, 0.0)).dot(patch.normal());
                        assert!(off.abs() < 1e-14);
                    }
                }
            }
            approx::assert_relative_eq!(area, patch.area(), max_relative = 1e-5);
        }
    }
}
