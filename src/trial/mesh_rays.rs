//! Shadow rays against the meshes of a case, each traced in more than one way: the ways must agree, and what each costs is
//! told.

use std::time::Instant;

use rand::RngExt;

use super::outcome::Timing;
use super::run::TrialError;
use crate::case::Case;
use crate::configuration::{Configuration, MeasurementPoint};
use crate::geometry::{DVec3, Shape};
use crate::sampling::{BLOCK, LANES, Lanes, Pattern, Squares, Strategy, Stream, StreamKey, Surface, SurfaceBlock};
use crate::scene::{Hierarchy, ShadowCache, ShadowRays, reach};

/// Shadow rays that compare each mesh's hierarchy with brute force.
const COMPARED_RAYS: u64 = 128;
/// How often each block is traced to compare the shadow cache, half of them with it.
const TURNS: usize = 8;

/// Traces the same shadow rays by hierarchy and by brute force, and with the shadow cache and without: they must agree, and
/// how long each takes is reported.
pub(super) fn compare_hierarchies(case: &Case, seed: u64) -> Result<Vec<Timing>, TrialError> {
    let configuration = &case.configuration;
    let reach = reach(configuration);
    let mut timings = Vec::new();
    for (mesh, shape) in configuration.occluders().iter().enumerate() {
        let Shape::Mesh(triangles) = shape else { continue };
        let rays = some_shadow_rays(configuration, seed);
        let start = Instant::now();
        let hierarchy = Hierarchy::new(triangles, reach);
        let build = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let fast: Vec<bool> = rays.iter().map(|(from, to)| hierarchy.blocks(*from, *to)).collect();
        let traversal = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let slow: Vec<bool> = rays.iter().map(|(from, to)| hierarchy.blocks_by_brute_force(*from, *to)).collect();
        let brute_force = start.elapsed().as_secs_f64();
        if let Some(ray) = (0..rays.len()).find(|ray| fast[*ray] != slow[*ray]) {
            let (from, to) = rays[ray];
            return Err(TrialError::HierarchyDisagrees { case: case.name.clone(), mesh, from, to });
        }
        for (stage, rays, seconds) in [
            ("hierarchy_build", triangles.triangles().len() as u64, build),
            ("hierarchy_rays", COMPARED_RAYS, traversal),
            ("brute_force_rays", COMPARED_RAYS, brute_force),
        ] {
            timings.push(Timing { stage, rays, seconds, efficiency: None });
        }
        timings.extend(compare_caches(case, mesh, &hierarchy, seed)?);
    }
    Ok(timings)
}

/// Shadow rays from points of the case to points on its sources.
fn some_shadow_rays(configuration: &Configuration, seed: u64) -> Vec<(DVec3, DVec3)> {
    let key = StreamKey::root(seed).with(configuration.digest().key());
    let mut draws = Stream::new(key);
    let surfaces: Vec<Surface> =
        configuration.sources().iter().filter_map(|source| Surface::new(source.shape())).collect();
    let mut pattern = Pattern::new(Strategy::Random, COMPARED_RAYS, Lanes::new(key.with(1), LANES));
    let (mut squares, mut places) = (Squares::default(), SurfaceBlock::default());
    let mut rays = Vec::with_capacity(COMPARED_RAYS as usize);
    while rays.len() < COMPARED_RAYS as usize {
        let surface = &surfaces[draws.random_range(0..surfaces.len())];
        pattern.fill(&mut squares, BLOCK);
        surface.place(&squares, BLOCK, &mut places);
        for i in 0..BLOCK {
            let from: &MeasurementPoint =
                &configuration.points()[draws.random_range(0..configuration.points().len())];
            let row = |row: &crate::sampling::Row| row[i / LANES][i % LANES];
            let offset = DVec3::new(row(&places.x), row(&places.y), row(&places.z));
            rays.push((from.position(), surface.origin() + offset));
        }
    }
    rays
}

/// Traces rays from all points to points on the sources that they share, as an estimator does, with the cache and without.
fn compare_caches(case: &Case, mesh: usize, hierarchy: &Hierarchy, seed: u64) -> Result<[Timing; 2], TrialError> {
    let configuration = &case.configuration;
    let key = StreamKey::root(seed).with(configuration.digest().key()).with(2);
    let (mut squares, mut places) = (Squares::default(), SurfaceBlock::default());
    // One for each pair of turns: a point that was asked about before would be found at once.
    let mut caches = [(); TURNS / 2].map(|()| ShadowCache::default());
    let (mut rays, mut seconds) = (0, [0.0; 2]);
    for (index, source) in configuration.sources().iter().enumerate() {
        let Some(surface) = Surface::new(source.shape()) else { continue };
        let lanes = Lanes::new(key.with(index as u64), LANES);
        Pattern::new(Strategy::Random, BLOCK as u64, lanes).fill(&mut squares, BLOCK);
        surface.place(&squares, BLOCK, &mut places);
        for (p, point) in configuration.points().iter().enumerate() {
            let from = point.position();
            let offset = surface.origin() - from;
            let mut block = ShadowRays::default();
            for k in 0..BLOCK {
                let (g, l) = (k / LANES, k % LANES);
                (block.x[g][l], block.y[g][l], block.z[g][l]) =
                    (places.x[g][l] + offset.x, places.y[g][l] + offset.y, places.z[g][l] + offset.z);
            }
            // Whoever comes first finds the hierarchy's memory cold: by turns, and once before.
            let mut warm = [[1.0; LANES]; BLOCK / LANES];
            hierarchy.shade(from, &block, BLOCK, &mut warm, None);
            for turn in 0..TURNS {
                let mut carried = [[1.0; LANES]; BLOCK / LANES];
                let way = (turn + p) % 2;
                let start = Instant::now();
                hierarchy.shade(from, &block, BLOCK, &mut carried, (way == 0).then_some(&mut caches[turn / 2]));
                seconds[way] += start.elapsed().as_secs_f64();
                if carried != warm {
                    return Err(TrialError::CacheDisagrees { case: case.name.clone(), mesh, point: p });
                }
            }
            rays += (TURNS / 2 * BLOCK) as u64;
        }
    }
    let timing = |stage, seconds| Timing { stage, rays, seconds, efficiency: None };
    Ok([timing("rays_with_cache", seconds[0]), timing("rays_without_cache", seconds[1])])
}
