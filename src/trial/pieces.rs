//! Rays from the light and paths from the eye, piece by piece: each a unit of the run.

use std::time::Instant;

use super::desk::{Desk, Portion, Stage};
use super::onlooker::{Onlooker, Stopped};
use crate::case::Case;
use crate::light::{LightPiece, LightRun, LightSettings, LightTracer};
use crate::path::{AsItIs, PathRun, PathSettings, PathTracer};

/// Light of a case, and the seconds it took.
///
/// - `rays`: in place of the case's own
/// - `None`: some of it is somebody else's
pub(super) fn light(
    case: &Case,
    seed: u64,
    rays: u64,
    stage: Stage,
    onlooker: &Onlooker,
) -> Result<Option<(LightRun, f64)>, Stopped> {
    if !onlooker.wants(stage) {
        return Ok(None);
    }
    let settings = LightSettings { rays, ..case.light.clone() };
    let tracer = LightTracer::new(&case.configuration, &settings, seed);
    onlooker.planned(rays)?;
    let mut sum = tracer.sum();
    let of = tracer.n_pieces() as u32;
    let (mut all, mut seconds) = (true, 0.0);
    for index in 0..of {
        let piece = u64::from(index);
        let fits = |found: &LightPiece| sum.fits(piece, found);
        let made = onlooker.unit(Portion { stage, index, of }, tracer.rays_of_piece(piece), fits, || {
            let start = Instant::now();
            let piece = tracer.piece(piece, &|rays| onlooker.traced(rays))?;
            Ok((piece, start.elapsed().as_secs_f64()))
        })?;
        match made {
            Some((piece, of_piece)) => {
                sum.add(&piece);
                seconds += of_piece;
            }
            None => all = false,
        }
    }
    Ok(all.then(|| (sum.finish(), seconds)))
}

/// Paths from every measurement point of a case, likewise.
///
/// - `paths`: from each point
pub(super) fn paths(
    case: &Case,
    seed: u64,
    paths: u64,
    next_event: bool,
    onlooker: &Onlooker,
) -> Result<Option<(PathRun, f64)>, Stopped> {
    let stage = Stage::Paths { next_event };
    if !onlooker.wants(stage) {
        return Ok(None);
    }
    let settings = PathSettings { next_event, ..PathSettings::default() };
    let tracer = PathTracer::new(&case.configuration, &settings, seed);
    let asked = tracer.asked(paths);
    let of_pieces = Pieces { nothing: asked.nothing(), of: asked.n_pieces(), rays: &|k| asked.paths_of_piece(k) };
    of_pieces.joined(stage, onlooker, |k, traced| tracer.piece_at_points(&asked, k, &AsItIs, traced))
}

/// Paths from all over the receiver. The receiver is there.
pub(super) fn survey(
    tracer: &PathTracer,
    paths: u64,
    onlooker: &Onlooker,
) -> Result<Option<(PathRun, f64)>, Stopped> {
    let Some(asked) = tracer.asked_over_receiver(paths) else { return Ok(None) };
    let of_pieces = Pieces { nothing: asked.nothing(), of: asked.n_pieces(), rays: &|k| asked.paths_of_piece(k) };
    of_pieces.joined(Stage::Survey, onlooker, |k, traced| tracer.piece_over_receiver(&asked, k, traced))
}

/// Told of paths.
type Traced<'a> = dyn Fn(u64) -> Result<(), Stopped> + Sync + 'a;

/// Of a run of paths.
struct Pieces<'a> {
    nothing: PathRun,
    of: u64,
    /// Paths of each piece, about.
    rays: &'a dyn Fn(u64) -> u64,
}

impl Pieces<'_> {
    fn joined(
        self,
        stage: Stage,
        onlooker: &Onlooker,
        piece: impl Fn(u64, &Traced) -> Result<PathRun, Stopped>,
    ) -> Result<Option<(PathRun, f64)>, Stopped> {
        let Pieces { mut nothing, of, rays } = self;
        onlooker.planned((0..of).map(rays).sum())?;
        let (mut all, mut seconds) = (true, 0.0);
        for k in 0..of {
            let part = Portion { stage, index: k as u32, of: of as u32 };
            let fits = |run: &PathRun| run.points.len() == nothing.points.len();
            let made = onlooker.unit(part, rays(k), fits, || {
                let start = Instant::now();
                let run = piece(k, &|rays| onlooker.traced(rays))?;
                Ok((run, start.elapsed().as_secs_f64()))
            })?;
            match made {
                Some((run, of_piece)) => {
                    nothing.merge(&run);
                    seconds += of_piece;
                }
                None => all = false,
            }
        }
        Ok(all.then_some((nothing, seconds)))
    }
}
