//! Predicted spreads of directions towards the sources, of directions that must find them, and of both weighed.

use crate::configuration::{Configuration, MeasurementPoint, Source};
use crate::oracle::Oracle;
use crate::oracle::variance::{Contribution, SampleMoments, Spread};
use crate::sampling::{Heuristic, Silhouette, Technique, View};

/// Spread of what one draw of a technique brings (for techniques that draw on each source, one draw on each).
pub(super) fn of_technique(
    oracle: &Oracle,
    configuration: &Configuration,
    technique: Technique,
    point: &MeasurementPoint,
) -> Option<Spread> {
    let sources = || configuration.sources().iter().enumerate();
    let sum = |spread: &dyn Fn(usize, &Source) -> Option<Spread>| {
        sources().try_fold(Spread::default(), |sum, (i, source)| Some(sum.plus(spread(i, source)?)))
    };
    match technique {
        Technique::Area => sum(&|i, _| Some(oracle.area_moments(i, point)?.spread())),
        Technique::SolidAngle => sum(&|i, source| {
            let mut view = View::default();
            Silhouette::new(source.shape())?.seen_from(point.position(), &mut view);
            let solid_angle = view.solid_angle();
            if solid_angle <= 0.0 {
                return Some(Spread::default());
            }
            let mut moments = oracle.sample_moments(i, point, |at| Contribution::by_solid_angle(at, solid_angle))?;
            moments.has_shadow |= view.misses();
            Some(moments.spread())
        }),
        Technique::Cosine => Some(oracle.cosine_moments(point)?.spread()),
        Technique::Mis(heuristic) => {
            let power = match heuristic {
                Heuristic::Balance => 1,
                Heuristic::Power => 2,
            };
            let by_area = sum(&|i, _| {
                Some(oracle.sample_moments(i, point, |at| Contribution::by_area_weighed(at, power))?.spread())
            })?;
            let by_cosine: Option<Vec<SampleMoments>> = sources()
                .map(|(i, _)| oracle.sample_moments(i, point, |at| Contribution::by_cosine_weighed(at, power)))
                .collect();
            Some(by_area.plus(SampleMoments::either(&by_cosine?).spread()))
        }
    }
}
