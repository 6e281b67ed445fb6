//! Bilinear interpolation on a triangle, whose sides cut texels.

use super::Raster;
use super::texels::sum;
use crate::geometry::parametrisation::clipped;
use crate::geometry::{Parametrisation, Texel, TexelGrid};

/// Interpolation between the middles of texels, times one factor.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bilinear {
    grid: TexelGrid,
    /// As the raster's, with values beyond the triangle's sides.
    values: Vec<f64>,
    factor: f64,
}

impl Bilinear {
    /// - `integral`: what the integral over the surface is to be
    pub fn new(map: &Parametrisation, raster: &Raster, integral: f64) -> Bilinear {
        let grid = raster.grid();
        let mut bilinear = Bilinear { grid, values: extended(map, raster), factor: 1.0 };
        let plain = bilinear.integral(map);
        if plain > 0.0 {
            bilinear.factor = integral / plain;
        }
        bilinear
    }

    /// What the interpolated values are multiplied by.
    pub fn factor(&self) -> f64 {
        self.factor
    }

    #[inline]
    pub fn at(&self, [s, t]: [f64; 2]) -> f64 {
        let place = |x: f64, n: usize| {
            // From the middle of the first texel to that of the last; beyond them constant.
            let x = (x * n as f64 - 0.5).clamp(0.0, (n - 1) as f64);
            let below = (x as usize).min(n.saturating_sub(2));
            (below, (below + 1).min(n - 1), x - below as f64)
        };
        let ((i, next_i, x), (j, next_j, y)) = (place(s, self.grid.ns()), place(t, self.grid.nt()));
        let value = |i: usize, j: usize| self.values[self.grid.index(Texel { i, j })];
        let row = |j: usize| value(i, j) + x * (value(next_i, j) - value(i, j));
        self.factor * (row(j) + y * (row(next_j) - row(j)))
    }

    /// Over the surface: within half a texel it is bilinear, and over a part of that, cut into triangles, the mean of the
    /// middles of three sides is exact for second degree.
    fn integral(&self, map: &Parametrisation) -> f64 {
        let Some(triangle) = map.map_triangle() else { return 0.0 };
        let (ns, nt) = (2 * self.grid.ns(), 2 * self.grid.nt());
        let side = |k: usize, n: usize| [k as f64 / n as f64, (k + 1) as f64 / n as f64];
        let halves = (0..ns * nt).map(|k| {
            let extent = [side(k % ns, ns), side(k / ns, nt)];
            let part = clipped(&triangle.corners(), extent);
            let (corner, [[s, _], [t, _]]) = (|k: usize| part[k], extent);
            let about = |p: [f64; 2]| [p[0] - s, p[1] - t];
            let middle = |a: [f64; 2], b: [f64; 2]| self.at([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
            sum((1..part.len().saturating_sub(1)).map(|k| {
                let [a, b, c] = [corner(0), corner(k), corner(k + 1)];
                let ([p, q, r], third) = ([about(a), about(b), about(c)], 1.0 / 3.0);
                let area = 0.5 * ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).abs();
                area * third * (middle(a, b) + middle(b, c) + middle(c, a))
            }))
        });
        sum(halves) * map.area() / triangle.area()
    }
}

/// The raster's values, but for texels that the triangle does not reach: the mean of those neighbours that it does.
fn extended(map: &Parametrisation, raster: &Raster) -> Vec<f64> {
    let grid = raster.grid();
    let reached: Vec<bool> = grid.texels().map(|texel| map.texel_area(grid, texel) > 0.0).collect();
    let of_texel = |texel: Texel| {
        if reached[grid.index(texel)] {
            return raster.value(texel);
        }
        let around = |k: usize, n: usize| k.saturating_sub(1)..(k + 2).min(n);
        let (mut total, mut count) = (0.0, 0.0);
        for j in around(texel.j, grid.nt()) {
            for i in around(texel.i, grid.ns()) {
                if reached[grid.index(Texel { i, j })] {
                    total += raster.value(Texel { i, j });
                    count += 1.0;
                }
            }
        }
        if count > 0.0 { total / count } else { 0.0 }
    };
    grid.texels().map(of_texel).collect()
}
