//! Shadow rays against the meshes of a case, each traced in more than one way: the ways must agree, and what each costs is
//! told.

use std::time::Instant;

use rand::RngExt;

use super::outcome::Timing;
use super::run::TrialError;
use crate::case::Case;
use crate::configuration::{Configuration, MeasurementPoint};
use crate::geometry::{DVec3, Shape};
use crate::number::Machine;
use crate::sampling::{
    BLOCK, LANES, Lanes, Pattern, Row, Squares, Strategy, Stream, StreamKey, Surface, SurfaceBlock,
};
use crate::scene::{Blocker, Help, Hierarchy, ShadowCache, ShadowRays, Target, reach};

/// Shadow rays that compare each mesh's hierarchy with brute force.
const COMPARED_RAYS: u64 = 128;
/// How often each block is traced to compare the shadow cache, half of them with it.
const TURNS: usize = 8;
/// As many rays are said to follow when a point looks for the silhouette: enough for all but the finest meshes.
const MANY_RAYS: u64 = 1 << 15;
/// Rays of a block that all carry something.
const ALL_LIT: Row = [[1.0; LANES]; BLOCK / LANES];

/// Traces the same shadow rays by hierarchy and by brute force, with the shadow cache and without, and where the silhouette
/// was found before: they must agree, and how long each takes is reported.
pub(super) fn compare_hierarchies(case: &Case, seed: u64) -> Result<Vec<Timing>, TrialError> {
    let configuration = &case.configuration;
    let reach = reach(configuration);
    let mut timings = Vec::new();
    for (mesh, shape) in configuration.occluders().iter().enumerate() {
        let Shape::Mesh(triangles) = shape else { continue };
        let rays = some_shadow_rays(configuration, seed);
        let start = Instant::now();
        let blocker = Blocker::new(shape, reach);
        let build = start.elapsed().as_secs_f64();
        let Some(hierarchy) = blocker.hierarchy() else { continue };
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
        let shared = shared_rays(configuration, seed);
        timings.extend(compare_caches(case, mesh, hierarchy, &shared)?);
        timings.extend(compare_visibility_maps(case, mesh, &blocker, &shared)?);
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
            let row = |row: &Row| row[i / LANES][i % LANES];
            let offset = DVec3::new(row(&places.x), row(&places.y), row(&places.z));
            rays.push((from.position(), surface.origin() + offset));
        }
    }
    rays
}

/// A block of rays from a point of the case to points on one of its sources, which all points share.
struct Shared {
    source: usize,
    point: usize,
    rays: ShadowRays,
}

/// For each source, and from every point, a block of rays.
fn shared_rays(configuration: &Configuration, seed: u64) -> Vec<Shared> {
    let key = StreamKey::root(seed).with(configuration.digest().key()).with(2);
    let (mut squares, mut places) = (Squares::default(), SurfaceBlock::default());
    let mut shared = Vec::new();
    for (source, shape) in configuration.sources().iter().map(|source| source.shape()).enumerate() {
        let Some(surface) = Surface::new(shape) else { continue };
        let lanes = Lanes::new(key.with(source as u64), LANES);
        Pattern::new(Strategy::Random, BLOCK as u64, lanes).fill(&mut squares, BLOCK);
        surface.place(&squares, BLOCK, &mut places);
        for (point, from) in configuration.points().iter().enumerate() {
            let offset = surface.origin() - from.position();
            let mut rays = ShadowRays::default();
            for k in 0..BLOCK {
                let (g, l) = (k / LANES, k % LANES);
                (rays.x[g][l], rays.y[g][l], rays.z[g][l]) =
                    (places.x[g][l] + offset.x, places.y[g][l] + offset.y, places.z[g][l] + offset.z);
            }
            shared.push(Shared { source, point, rays });
        }
    }
    shared
}

/// Traces rays as an estimator does, with the cache and without.
fn compare_caches(
    case: &Case,
    mesh: usize,
    hierarchy: &Hierarchy,
    shared: &[Shared],
) -> Result<[Timing; 2], TrialError> {
    // One for each pair of turns: a point that was asked about before would be found at once.
    let mut caches = [(); TURNS / 2].map(|()| ShadowCache::default());
    let mut seconds = [0.0; 2];
    for Shared { point, rays, .. } in shared {
        let from = case.configuration.points()[*point].position();
        // Whoever comes first finds the hierarchy's memory cold: by turns, and once before.
        let mut warm = ALL_LIT;
        hierarchy.shade(from, rays, BLOCK, &mut warm, None);
        for turn in 0..TURNS {
            let mut carried = ALL_LIT;
            let way = (turn + point) % 2;
            let start = Instant::now();
            hierarchy.shade(from, rays, BLOCK, &mut carried, (way == 0).then_some(&mut caches[turn / 2]));
            seconds[way] += start.elapsed().as_secs_f64();
            if carried != warm {
                return Err(TrialError::CacheDisagrees { case: case.name.clone(), mesh, point: *point });
            }
        }
    }
    let rays = (shared.len() * TURNS / 2 * BLOCK) as u64;
    let timing = |stage, seconds| Timing { stage, rays, seconds, efficiency: None };
    Ok([timing("rays_with_cache", seconds[0]), timing("rays_without_cache", seconds[1])])
}

/// Looks for the mesh's silhouette from every point, and shades rays with what was found and without.
fn compare_visibility_maps(
    case: &Case,
    mesh: usize,
    blocker: &Blocker,
    shared: &[Shared],
) -> Result<Vec<Timing>, TrialError> {
    let (machine, configuration) = (Machine::new(), &case.configuration);
    let targets: Vec<Target> = configuration.sources().iter().map(|source| Target::new(source.shape())).collect();
    let (mut searched, mut found, mut looking, mut shading) = (0, 0, 0.0, 0.0);
    for Shared { source, point, rays } in shared {
        let target = &targets[*source];
        let from = configuration.points()[*point].position();
        // The first search of all finds the edges, too.
        if searched == 0 {
            blocker.visibility(machine, from, target, MANY_RAYS);
        }
        let start = Instant::now();
        let visibility = blocker.visibility(machine, from, target, MANY_RAYS);
        looking += start.elapsed().as_secs_f64();
        searched += 1;
        let Some(visibility) = visibility else { continue };
        let (mut traced, mut carried) = (ALL_LIT, ALL_LIT);
        blocker.shade_on(machine, from, rays, BLOCK, &mut traced, Help::default());
        let start = Instant::now();
        let help = Help { visibility: Some(&visibility), ..Help::default() };
        blocker.shade_on(machine, from, rays, BLOCK, &mut carried, help);
        shading += start.elapsed().as_secs_f64();
        found += BLOCK as u64;
        if carried != traced {
            return Err(TrialError::SilhouetteDisagrees { case: case.name.clone(), mesh, point: *point });
        }
    }
    let timing = |stage, rays, seconds| Timing { stage, rays, seconds, efficiency: None };
    let both = [timing("silhouette_search", searched, looking), timing("rays_past_silhouette", found, shading)];
    Ok(both.into_iter().filter(|timing| timing.rays > 0).collect())
}
