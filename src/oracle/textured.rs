//! Sources whose exitance varies over them.
//!
//! | texture | on | answer |
//! |---|---|---|
//! | constant texels | rectangle, triangle | a sum of closed forms: one polygon for each run of equal texels |
//! | constant texels | disk, sphere | strips, parted at the texels' borders; along a strip closed |
//! | interpolated | any | strips, parted where the interpolation bends |
//! | polynomial | rectangle | in closed form (or by smooth cubature) where nothing is in the way and the planes are parallel, else strips |

use glam::DVec3;

use super::body::{Body, Flat};
use super::exact::{BodyAt, Oracle, Seen};
use super::outline;
use super::quadrature::{self, Grain, Line, WeightedStrips};
use super::truth::{Method, Sight};
use crate::configuration::MeasurementPoint;
use crate::geometry::parametrisation::clipped;
use crate::geometry::{Isoline, Texel};
use crate::texture::{Lookup, Raster, Texels, Texture};

/// Relative errors of strips that will do for a value, and for a check.
pub(super) const PRECISE: f64 = 1e-12;
pub(super) const ROUGH: f64 = 1e-5;

/// What one source brings to a point, W/m².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Light {
    pub value: f64,
    /// Nothing being in the way.
    pub unoccluded: f64,
    pub bound: f64,
    pub method: Method,
    /// Whether the exitance jumps somewhere on the source.
    pub jumps: bool,
}

impl Light {
    /// Of one exitance.
    pub fn uniform(exitance: f64, seen: &Seen) -> Light {
        Light {
            value: exitance * seen.visible.value,
            unoccluded: exitance * seen.unoccluded,
            bound: exitance * seen.visible.bound,
            method: seen.method,
            jumps: false,
        }
    }
}

impl Oracle {
    /// What a source brings to a point.
    ///
    /// - `precision`: relative, where it takes quadrature
    pub(super) fn light(&self, index: usize, point: &MeasurementPoint, precision: f64) -> Light {
        let seen = self.of_body(BodyAt::Source(index), point);
        let textured = self.light_of_texture(index, point, &seen, precision);
        textured.unwrap_or_else(|| Light::uniform(self.sources[index].exitance, &seen))
    }

    /// The same of a textured source; `None` of another.
    ///
    /// - `seen`: its shape, as the point sees it
    pub(super) fn light_of_texture(
        &self,
        index: usize,
        point: &MeasurementPoint,
        seen: &Seen,
        precision: f64,
    ) -> Option<Light> {
        let source = &self.sources[index];
        let texture = source.texture.as_ref()?;
        let jumps = texture.seams().is_constant_between;
        let dark = Light { value: 0.0, unoccluded: 0.0, bound: 0.0, method: Method::ClosedForm, jumps: false };
        if seen.sight == Sight::Below {
            return Some(dark);
        }
        if !source.parts.is_empty() {
            return Some((0..source.parts.len()).fold(Light { jumps, ..dark }, |sum, part| {
                let light = Light::uniform(source.parts[part].1, &self.of_body(BodyAt::Part(index, part), point));
                Light {
                    value: sum.value + light.value,
                    unoccluded: sum.unoccluded + light.unoccluded,
                    bound: sum.bound + light.bound + f64::EPSILON * (sum.value + light.value),
                    ..sum
                }
            }));
        }
        if let Texture::Polynomial(on) = &**texture
            && seen.sight == Sight::Whole
        {
            let truth = on.polynomial().irradiance(on.rectangle(), point);
            let value = truth.irradiance.watts_per_square_metre();
            let bound = truth.bound.watts_per_square_metre();
            return Some(Light { value, unoccluded: value, bound, method: truth.method, ..dark });
        }
        let others = (0..self.sources.len()).filter(|i| *i != index).map(|i| &self.sources[i].body);
        let others: Vec<&Body> = self.occluders.iter().chain(others).collect();
        let (n, eye) = (point.normal(), point.position() * self.scale);
        let found = self.by_strips_between_seams(texture, n, &source.body, &others, eye, precision);
        let (value, bound) = if seen.sight == Sight::Hidden { (0.0, 0.0) } else { (found.value, found.error) };
        Some(Light { value, unoccluded: found.unoccluded, bound, method: Method::Quadrature, jumps })
    }

    /// By strips across a source, parted where its texture is not smooth.
    pub(super) fn by_strips_between_seams(
        &self,
        texture: &Texture,
        n: DVec3,
        body: &Body,
        others: &[&Body],
        eye: DVec3,
        precision: f64,
    ) -> WeightedStrips {
        // Both are points of the surface; their coordinates may be large.
        let anchor = body.center / self.scale - texture.anchor();
        let emission = |place: DVec3| texture.at_offset(anchor + place / self.scale);
        let grain = grain(texture, body.center, self.scale);
        quadrature::visible_between(n, body, others, eye, &emission, &grain, precision)
    }
}

/// The lines on a source where its texture is not smooth, relative to its centre.
pub(super) fn grain(texture: &Texture, center: DVec3, scale: f64) -> Grain {
    let Some(map) = texture.texels().map(Texels::map) else { return Grain::default() };
    let seams = texture.seams();
    let anchor = map.anchor() * scale - center;
    let from_center = |offset: DVec3| anchor + offset * scale;
    let line = |isoline: Isoline| match isoline {
        Isoline::Segment(ends) => Line::Segment(ends.map(from_center)),
        Isoline::Circle { center, normal, radius } => {
            Line::Circle { center: from_center(center), normal, radius: radius * scale }
        }
    };
    // With half a turn more, where s wraps, it is the same line.
    let is_new = |s: &&f64| {
        let before = |other: &f64| (**s - 0.5 - other).abs() < 1e-12;
        !map.wraps() || **s < 0.5 || !seams.s.iter().any(before)
    };
    let along_s = seams.s.iter().filter(is_new).filter_map(|s| map.line_of_s(*s)).map(|isoline| (0, line(isoline)));
    let along_t = seams.t.iter().filter_map(|t| map.line_of_t(*t)).map(|isoline| (1, line(isoline)));
    let ends = [0.0, 1.0].into_iter().zip(map.poles()).filter(|(_, is_pole)| *is_pole);
    let poles = ends.map(|(t, _)| from_center(map.offset([0.0, t])));
    Grain {
        lines: along_s.chain(along_t).collect(),
        poles: poles.collect(),
        is_constant_between: seams.is_constant_between,
    }
}

/// The polygons that a flat source of constant texels is made of, each with its exitance; none of another texture.
///
/// - `scale`: what lengths are multiplied by
pub(super) fn parts(texture: &Texture, scale: f64) -> Vec<(Body, f64)> {
    let Some(texels) = texture.texels() else { return Vec::new() };
    let map = texels.map();
    if texels.lookup() != Lookup::Nearest || map.wraps() {
        return Vec::new();
    }
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    // In the order of the surface's own corners, however the map is turned.
    let outline = map.map_triangle().map_or(square.to_vec(), |triangle| triangle.corners().to_vec());
    let of_run = |run: Run| {
        let mut part = clipped(&outline, run.extent);
        // What a corner touches is a point or a line.
        part.dedup();
        if part.last() == part.first() {
            part.pop();
        }
        if part.len() < 3 {
            return None;
        }
        // Their coordinates may be large.
        let offsets: Vec<DVec3> = part.iter().map(|at| map.offset(*at) * scale).collect();
        let area: DVec3 =
            (1..offsets.len() - 1).map(|k| (offsets[k] - offsets[0]).cross(offsets[k + 1] - offsets[0])).sum();
        let normal = area.try_normalize()?;
        let flat = Flat {
            normal,
            origin: map.anchor() * scale,
            edges: outline::loop_of(offsets.len()),
            offsets,
            convex: true,
        };
        Some((Body::of_flat(flat), run.value))
    };
    runs(texels.raster()).into_iter().filter_map(of_run).collect()
}

/// A rectangle of equal texels.
struct Run {
    extent: [[f64; 2]; 2],
    value: f64,
}

/// Equal neighbours as rectangles, as far along s as they go and then as far along t; those that send out nothing left out.
fn runs(raster: &Raster) -> Vec<Run> {
    let grid = raster.grid();
    let mut taken = vec![false; grid.n_texels()];
    let mut runs = Vec::new();
    for first in grid.texels() {
        let value = raster.value(first);
        if taken[grid.index(first)] || value == 0.0 {
            continue;
        }
        let is_free = |taken: &[bool], i: usize, j: usize| {
            let texel = Texel { i, j };
            !taken[grid.index(texel)] && raster.value(texel) == value
        };
        let end_i = (first.i + 1..grid.ns()).find(|i| !is_free(&taken, *i, first.j)).unwrap_or(grid.ns());
        let row_ends = |j: &usize| (first.i..end_i).any(|i| !is_free(&taken, i, *j));
        let end_j = (first.j + 1..grid.nt()).find(row_ends).unwrap_or(grid.nt());
        for j in first.j..end_j {
            for i in first.i..end_i {
                taken[grid.index(Texel { i, j })] = true;
            }
        }
        let share = |k: usize, n: usize| k as f64 / n as f64;
        let extent = [
            [share(first.i, grid.ns()), share(end_i, grid.ns())],
            [share(first.j, grid.nt()), share(end_j, grid.nt())],
        ];
        runs.push(Run { extent, value });
    }
    runs
}
