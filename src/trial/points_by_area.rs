//! In place of [`techniques`](super) where no study measures them: the judge of guests asks of points by area alone.

use crate::configuration::{Configuration, MeasurementPoint};
use crate::oracle::Oracle;
use crate::oracle::variance::Spread;
use crate::sampling::Technique;

/// Nothing is predicted of other techniques without the feature `studies`.
pub(super) fn of_technique(_: &Oracle, _: &Configuration, _: Technique, _: &MeasurementPoint) -> Option<Spread> {
    None
}
