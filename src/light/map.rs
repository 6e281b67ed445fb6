//! The caustic map: flux left in the texels of a diffuse surface, and what light there is between them.

use std::f64::consts::PI;

use super::ledger::{Moments, Sum};
use crate::configuration::ReceiverShape;
use crate::geometry::parametrisation::clipped;
use crate::geometry::{DVec3, MapTriangle, Parametrisation, Texel, TexelGrid};
use crate::radiometry::{Albedo, Irradiance, Radiosity};

/// A diffuse surface as rays land on it.
#[derive(Clone, Debug)]
pub(crate) struct Landing {
    pub parametrisation: Parametrisation,
    pub grid: TexelGrid,
    /// Texels of the maps before this one.
    pub first: usize,
}

impl Landing {
    pub fn new(shape: &ReceiverShape, grid: TexelGrid, first: usize) -> Landing {
        let parametrisation = match shape {
            ReceiverShape::Rectangle(s) => Parametrisation::rectangle(s),
            ReceiverShape::Disk(s) => Parametrisation::disk(s, None).expect("a tangent lies across its normal"),
            ReceiverShape::Sphere(s) => {
                Parametrisation::sphere(s, DVec3::Z, DVec3::X).expect("the axes are perpendicular")
            }
            ReceiverShape::Triangle(s) => {
                let map = MapTriangle::similar_to(s.vertices()).unwrap_or(MapTriangle::HALF_SQUARE);
                Parametrisation::triangle(s.vertices(), map).expect("a valid triangle has a map")
            }
        };
        Landing { parametrisation, grid, first }
    }
    /// The number of a texel through all maps and both kinds of light.
    #[inline(always)]
    pub fn cell(&self, at: DVec3, is_bent: bool) -> u32 {
        let texel = self.grid.texel(self.parametrisation.to_map(at));
        2 * (self.first + self.grid.index(texel)) as u32 + u32::from(is_bent)
    }
}

/// Which light of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Light {
    /// Straight from the source.
    Direct,
    /// By way of mirrors and glass.
    Bent,
    Both,
}

/// The texels of one diffuse surface.
#[derive(Clone, Debug)]
pub struct TexelMap {
    parametrisation: Parametrisation,
    grid: TexelGrid,
    /// Direct and bent, `[nt][ns]` each.
    light: [Vec<Moments>; 2],
    /// What the interpolation of each texel integrates to, square metres; none where that is the texel's area.
    reach: Option<Vec<f64>>,
    n_groups: u64,
}

impl TexelMap {
    pub(super) fn new(landing: &Landing) -> TexelMap {
        let (parametrisation, grid) = (landing.parametrisation, landing.grid);
        let light = [(); 2].map(|()| vec![Moments::default(); grid.n_texels()]);
        let reach = parametrisation.map_triangle().map(|triangle| {
            let metres = parametrisation.area() / triangle.area();
            grid.texels().map(|texel| metres * hat_over(triangle, grid, texel)).collect()
        });
        TexelMap { parametrisation, grid, light, reach, n_groups: 0 }
    }
    /// What groups left in a texel; `light`: 0 for direct, 1 for bent.
    pub(super) fn merge(&mut self, texel: usize, light: usize, left: &Moments) {
        self.light[light][texel].merge(left);
    }
    pub(super) fn close(&mut self, n_groups: u64) {
        self.n_groups = n_groups;
    }

    pub fn parametrisation(&self) -> &Parametrisation {
        &self.parametrisation
    }
    pub fn grid(&self) -> TexelGrid {
        self.grid
    }
    /// Independent groups of rays that left their flux.
    pub fn n_groups(&self) -> u64 {
        self.n_groups
    }

    /// The flux in a texel, W, with its spread over groups of rays.
    ///
    /// The squares of direct and bent light together are those of either alone: groups that left both in one texel count
    /// as two, so that the variance may be off there by twice the covariance, which is small where groups are many.
    pub fn moments(&self, texel: Texel, light: Light) -> Moments {
        let at = |kind: usize| self.light[kind][self.grid.index(texel)];
        match light {
            Light::Direct => at(0),
            Light::Bent => at(1),
            Light::Both => {
                let mut both = at(0);
                both.merge(&at(1));
                both
            }
        }
    }
    /// Exact, square metres.
    pub fn area(&self, texel: Texel) -> f64 {
        self.parametrisation.texel_area(self.grid, texel)
    }
    /// Mean over a texel: flux over exact area. `None` for a texel that no part of the surface lies in.
    pub fn irradiance(&self, texel: Texel, light: Light) -> Option<Irradiance> {
        let area = self.area(texel);
        (area > 0.0).then(|| Irradiance::new(self.moments(texel, light).watts() / area))
    }
    /// Albedo × flux / area.
    pub fn radiosity(&self, texel: Texel, light: Light, albedo: Albedo) -> Option<Radiosity> {
        self.irradiance(texel, light).map(|irradiance| irradiance * albedo)
    }
    /// All flux of the map, W.
    pub fn total(&self, light: Light) -> f64 {
        let mut total = Sum::default();
        for (kind, texels) in self.light.iter().enumerate() {
            if light == Light::Both || (light == Light::Bent) == (kind == 1) {
                texels.iter().for_each(|texel| total += texel.flux);
            }
        }
        total.value()
    }

    /// The irradiance of the texel that holds a point of the surface.
    pub fn nearest(&self, point: DVec3, light: Light) -> Irradiance {
        let texel = self.grid.texel(self.parametrisation.to_map(point));
        self.irradiance(texel, light).unwrap_or_default()
    }

    /// The irradiance between texels. Its integral over the surface is the deposited flux, and a surface evenly lit looks
    /// so (near the slanted sides of a triangle, to the order of a texel's width).
    ///
    /// At each border between texels the irradiance runs linearly from one to the other, over a width that is the same on
    /// either side as measured in *area*: half of the smaller of both texels each. What a texel gives to its neighbour's
    /// ground is then what the neighbour's ramp leaves free on its own, so each texel's share integrates to its area.
    /// Where texels are equal this is the common bilinear interpolation. On a triangle, where texels are cut, each texel's
    /// ramp is divided by its own integral instead.
    pub fn interpolated(&self, point: DVec3, light: Light) -> Irradiance {
        Irradiance::new(self.interpolated_at(self.parametrisation.to_map(point), light))
    }

    /// The same, in the map's coordinates, W/m².
    pub fn interpolated_at(&self, [s, t]: [f64; 2], light: Light) -> f64 {
        let (ns, nt) = (self.grid.ns(), self.grid.nt());
        let along_s = ramp(s * ns as f64, ns, |k| k as f64, self.parametrisation.wraps());
        let along_t = match self.parametrisation.share_below(t) {
            Some(share) => {
                let edge = |k: usize| self.parametrisation.share_below(k as f64 / nt as f64).unwrap_or(0.0);
                let row = self.grid.texel([s, t]).j;
                ramp_in(share, row, nt, edge, false)
            }
            None => ramp(t * nt as f64, nt, |k| k as f64, false),
        };
        let mut irradiance = 0.0;
        for (j, weight_t) in along_t {
            for (i, weight_s) in along_s {
                let weight = weight_s * weight_t;
                if weight > 0.0 {
                    let texel = Texel { i, j };
                    let reach = match &self.reach {
                        Some(reach) => reach[self.grid.index(texel)],
                        None => self.area(texel),
                    };
                    // A texel without any of the surface holds no flux.
                    if reach > 0.0 {
                        irradiance += weight * self.moments(texel, light).watts() / reach;
                    }
                }
            }
        }
        irradiance
    }
}

/// The two cells whose values are mixed at x, with their weights. Cells of equal width.
fn ramp(x: f64, n: usize, edge: impl Fn(usize) -> f64, wraps: bool) -> [(usize, f64); 2] {
    let cell = (x.max(0.0) as usize).min(n - 1);
    ramp_in(x, cell, n, edge, wraps)
}

/// The same for cells whose borders are given; x lies in `cell`.
fn ramp_in(x: f64, cell: usize, n: usize, edge: impl Fn(usize) -> f64, wraps: bool) -> [(usize, f64); 2] {
    let (low, high) = (edge(cell), edge(cell + 1));
    let width = high - low;
    let width_of = |k: usize| edge(k + 1) - edge(k);
    // A neighbour, and the half width of the ramp towards it.
    let (before, after) = match (cell, n) {
        (_, 1) => (None, None),
        (0, _) => (wraps.then_some(n - 1), Some(1)),
        (k, n) if k + 1 == n => (Some(k - 1), wraps.then_some(0)),
        (k, _) => (Some(k - 1), Some(k + 1)),
    };
    let (from_low, to_high) = ((x - low).max(0.0), (high - x).max(0.0));
    let mixed = |neighbour: Option<usize>, distance: f64| {
        let neighbour = neighbour?;
        let half = 0.5 * width.min(width_of(neighbour));
        (distance < half).then(|| {
            let weight = 0.5 * (1.0 - distance / half);
            [(cell, 1.0 - weight), (neighbour, weight)]
        })
    };
    mixed(before, from_low).or_else(|| mixed(after, to_high)).unwrap_or([(cell, 1.0), (cell, 0.0)])
}

/// The integral of a texel's bilinear hat over the part of the map that a triangle covers, as a share of the unit square.
fn hat_over(triangle: &MapTriangle, grid: TexelGrid, texel: Texel) -> f64 {
    let (ns, nt) = (grid.ns() as f64, grid.nt() as f64);
    // Outer halves of outer texels are flat.
    let hat = |x: f64, k: usize, n: usize| {
        let off = x - (k as f64 + 0.5);
        let flat = (k == 0 && off < 0.0) || (k + 1 == n && off > 0.0);
        if flat { 1.0 } else { (1.0 - off.abs()).max(0.0) }
    };
    let value = |[s, t]: [f64; 2]| hat(s * ns, texel.i, grid.ns()) * hat(t * nt, texel.j, grid.nt());
    let pieces = |k: usize, n: f64| {
        let middle = (k as f64 + 0.5) / n;
        [[(middle - 1.0 / n).max(0.0), middle], [middle, (middle + 1.0 / n).min(1.0)]]
    };
    let mut integral = 0.0;
    for piece_s in pieces(texel.i, ns) {
        for piece_t in pieces(texel.j, nt) {
            // The outer halves end at the square's border, where a piece may still hold both a flat and a sloping part: it
            // does not, since both meet at the middle.
            let part = clipped(&triangle.corners(), [piece_s, piece_t]);
            for k in 1..part.len().saturating_sub(1) {
                let [a, b, c] = [part[0], part[k], part[k + 1]];
                let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
                // Middles of the sides: exact for the second degree, which a product of two lines is.
                let middle = |p: [f64; 2], q: [f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
                integral += area / 3.0 * (value(middle(a, b)) + value(middle(b, c)) + value(middle(c, a)));
            }
        }
    }
    integral
}

/// Light on rings around a point of the receiver, by the number of interactions on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct RingMap {
    pub rings: super::settings::Rings,
    /// `[depth + 1][count]`.
    pub(super) cells: Vec<Moments>,
    pub(super) n_groups: u64,
}

impl RingMap {
    /// What light of one order left in a ring, W.
    pub fn moments(&self, order: usize, ring: usize) -> Moments {
        self.cells.get(order * self.rings.count + ring).copied().unwrap_or_default()
    }
    /// Independent groups of rays.
    pub fn n_groups(&self) -> u64 {
        self.n_groups
    }
    /// Of a whole ring in a plane, π (r₁² − r₀²), square metres. A receiver that cuts the ring has less.
    pub fn area(&self, ring: usize) -> f64 {
        let [inner, outer] = self.rings.radii(ring);
        PI * (outer - inner) * (outer + inner)
    }
}

/// Light on tiles of the receiver, by the number of interactions on its way.
#[derive(Clone, Debug)]
pub struct TileMap {
    pub tiles: TexelGrid,
    pub(super) parametrisation: Parametrisation,
    /// `[depth + 1][n_tiles]`.
    pub(super) cells: Vec<Moments>,
    pub(super) n_groups: u64,
}

impl TileMap {
    /// What light of one order left in a tile, W.
    pub fn moments(&self, order: usize, tile: Texel) -> Moments {
        self.cells.get(order * self.tiles.n_texels() + self.tiles.index(tile)).copied().unwrap_or_default()
    }
    /// Independent groups of rays.
    pub fn n_groups(&self) -> u64 {
        self.n_groups
    }
    /// Exact, square metres.
    pub fn area(&self, tile: Texel) -> f64 {
        self.parametrisation.texel_area(self.tiles, tile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Disk, Rectangle, Sphere, Triangle};

    fn shapes() -> [ReceiverShape; 4] {
        [
            ReceiverShape::Rectangle(Rectangle::new(DVec3::ONE, DVec3::X * 2.0, DVec3::Z).unwrap()),
            ReceiverShape::Disk(Disk::new(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0), 2.0).unwrap()),
            ReceiverShape::Sphere(Sphere::new(DVec3::ONE, 0.5).unwrap()),
            ReceiverShape::Triangle(Triangle::new([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 2.0, 1.0)]).unwrap()),
        ]
    }

    /// An irregular map: flux wherever there is surface.
    fn filled(shape: &ReceiverShape, ns: usize, nt: usize, flux: impl Fn(usize, f64) -> f64) -> TexelMap {
        let grid = TexelGrid::new(ns, nt).unwrap();
        let mut map = TexelMap::new(&Landing::new(shape, grid, 0));
        for texel in grid.texels() {
            let area = map.area(texel);
            if area > 0.0 {
                let mut left = Moments::default();
                left.add(flux(grid.index(texel), area));
                map.merge(grid.index(texel), 1, &left);
            }
        }
        map
    }

    /// Exact integral of the interpolated map: it is bilinear in s and the area's coordinate between all borders and middles,
    /// and two Gauss points a piece are exact for that. (A triangle's pieces are cut: `hat_over` is compared instead.)
    fn integral(map: &TexelMap) -> f64 {
        let grid = map.grid();
        let gauss = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
        let of_t = |share: f64| map.parametrisation().t_of_share(share).unwrap();
        let edge = |j: usize| map.parametrisation().share_below(j as f64 / grid.nt() as f64).unwrap();
        // Breaks where ramps end.
        let mut shares = vec![0.0, 1.0];
        for j in 1..grid.nt() {
            let half = 0.5 * (edge(j + 1) - edge(j)).min(edge(j) - edge(j - 1));
            shares.extend([edge(j) - half, edge(j), edge(j) + half]);
        }
        shares.sort_by(f64::total_cmp);
        let mut sum = 0.0;
        for half in 0..2 * grid.ns() {
            for pair in shares.windows(2) {
                for u in gauss {
                    for v in gauss {
                        let s = (half as f64 + u) / (2 * grid.ns()) as f64;
                        let t = of_t(pair[0] + (pair[1] - pair[0]) * v);
                        sum += 0.25 * (pair[1] - pair[0]) / (2 * grid.ns()) as f64
                            * map.interpolated_at([s, t], Light::Bent);
                    }
                }
            }
        }
        sum * map.parametrisation().area()
    }

    #[test]
    fn the_interpolated_map_keeps_the_flux() {
        for shape in &shapes()[..3] {
            for (ns, nt) in [(1, 1), (1, 2), (2, 1), (3, 2), (5, 8), (16, 9)] {
                let map = filled(shape, ns, nt, |k, _| 1.0 + (k as f64 * 0.618).fract());
                let (kept, total) = (integral(&map), map.total(Light::Bent));
                assert!((kept / total - 1.0).abs() < 1e-12, "{shape:?} {ns} × {nt}: {kept} of {total}");
            }
        }
    }

    #[test]
    fn the_interpolated_map_of_a_triangle_keeps_the_flux() {
        let shape = shapes()[3];
        for (ns, nt) in [(1, 1), (2, 2), (3, 4), (7, 5)] {
            let map = filled(&shape, ns, nt, |k, _| 1.0 + (k as f64 * 0.618).fract());
            let grid = map.grid();
            // The hats sum to one, so their integrals sum to the area.
            let whole: f64 = map.reach.as_ref().unwrap().iter().sum();
            assert!((whole / map.parametrisation().area() - 1.0).abs() < 1e-12, "{ns} × {nt}: {whole}");
            // By many points: the error of the midpoint rule on a cut cell is a cell's.
            let triangle = map.parametrisation().map_triangle().unwrap().corners();
            let n = 400;
            let mut sum = 0.0;
            let mut count = 0;
            for i in 0..n {
                for j in 0..n - i {
                    for (a, b) in [(1.0, 1.0), (2.0, 2.0)] {
                        let (a, b) =
                            ((f64::from(i) + a / 3.0) / f64::from(n), (f64::from(j) + b / 3.0) / f64::from(n));
                        if a + b < 1.0 {
                            let [q0, q1, q2] = triangle;
                            let at = [0, 1].map(|k| q0[k] + a * (q1[k] - q0[k]) + b * (q2[k] - q0[k]));
                            sum += map.interpolated_at(at, Light::Bent);
                            count += 1;
                        }
                    }
                }
            }
            let kept = sum / f64::from(count) * map.parametrisation().area();
            let total = map.total(Light::Bent);
            assert!((kept / total - 1.0).abs() < 1e-4, "{ns} × {nt} {grid:?}: {kept} of {total}");
        }
    }

    #[test]
    fn an_evenly_lit_surface_looks_so() {
        for shape in &shapes()[..3] {
            let map = filled(shape, 7, 6, |_, area| 3.0 * area);
            for k in 0..500 {
                let at = [(f64::from(k) * 0.618).fract(), (f64::from(k) * 0.414).fract()];
                let (smooth, point) = (map.interpolated_at(at, Light::Bent), map.parametrisation().to_surface(at));
                assert!((smooth / 3.0 - 1.0).abs() < 1e-12, "{shape:?} {at:?}: {smooth}");
                let plain = map.nearest(point, Light::Bent).watts_per_square_metre();
                assert!((plain / 3.0 - 1.0).abs() < 1e-12);
                assert_eq!(map.nearest(point, Light::Direct).watts_per_square_metre(), 0.0);
            }
        }
    }

    #[test]
    fn the_interpolation_has_no_steps() {
        for shape in &shapes() {
            let map = filled(shape, 5, 6, |k, area| area * (1.0 + (k as f64 * 0.618).fract()));
            for k in 0..2000 {
                // Along a slanted line over the map, past the seam.
                let at = |k: f64| [(k * 0.0137).fract(), 0.02 + 0.96 * (0.5 + 0.5 * (k * 0.003).sin())];
                let (here, there) = (at(f64::from(k)), at(f64::from(k) + 1e-9));
                let step = map.interpolated_at(here, Light::Bent) - map.interpolated_at(there, Light::Bent);
                let inside = map.parametrisation().map_triangle().is_none() && map.parametrisation().wraps();
                let near_seam = here[0] > 0.999 || there[0] < here[0];
                assert!(step.abs() < 1e-6 || (near_seam && !inside), "{shape:?} {here:?}: {step:e}");
            }
        }
    }
}
