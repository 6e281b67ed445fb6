//! The verdict on a picture: which pixels are watched, how many pictures it takes, and what came of it.
//!
//! Judged are the watched pixels one by one, and a mean: that of their direct light plus that of the bent light over the whole
//! map, which all of its rays decide.

use std::collections::BTreeMap;

use super::bent::Texels;
use super::{Due, PictureSettings};
use crate::case::{Case, Study};
use crate::configuration::{Arrangement, Configuration, Contents, MeasurementPoint};
use crate::eye::ReceiverView;
use crate::light::{LightSettings, LightTracer};
use crate::oracle::Oracle;
use crate::oracle::optics::Bounded;
use crate::statistics::evidence::{THRESHOLD_LOG10, ln_average, log10_capped, smallest_shift};
use crate::statistics::interval::Z_95;
use crate::statistics::{Capital, Observed, PowerSums, Statement, Verdict};
use crate::trial::outcome::JudgedProperty;
use crate::trial::predict::Predictions;

/// Watched pixels along either side, at most.
const SIDE: usize = 12;
/// As many more where the bent light is.
const BRIGHT: usize = 72;
/// Pictures that are made at least: fewer could not fail a pixel.
pub(super) const FEWEST: u64 = 32;
/// And at most.
const MOST: u64 = 256;
/// A picture is a look: what must have been seen is so much coarser than the study's smallest bias in the mean.
const COARSER: f64 = 5.0;
/// Rounding of an estimate, relative.
const ROUNDING: f64 = 1e-9;
/// Of the mean of all watched pixels: a darker one is watched, and no promise is made of it.
const WELL_LIT: f64 = 0.1;

/// Columns and rows of the pixels that are watched: those of a lattice that lie on the receiver.
pub(super) fn lattice(view: &ReceiverView) -> Vec<(usize, usize)> {
    let [width, height] = view.pixels();
    let along = |n: usize| -> Vec<usize> {
        let count = n.min(SIDE);
        (0..count).map(|k| (2 * k + 1) * n / (2 * count)).collect()
    };
    let places = along(height).into_iter().flat_map(|y| along(width).into_iter().map(move |x| (x, y)));
    places.filter(|(x, y)| view.element(*x as f64 + 0.5, *y as f64 + 0.5).is_some()).collect()
}

/// More pixels, where the bent light is: each stands for the same share of it, row by row.
pub(super) fn bright(view: &ReceiverView, texels: &Texels) -> Vec<(usize, usize)> {
    let [width, height] = view.pixels();
    let light = |k: usize| {
        let point = view.element((k % width) as f64 + 0.5, (k / width) as f64 + 0.5)?;
        texels.at(&point).map(|mean| mean.value)
    };
    let lights: Vec<f64> = (0..width * height).map(|k| light(k).unwrap_or(0.0)).collect();
    let step = lights.iter().sum::<f64>() / BRIGHT as f64;
    let (mut gathered, mut next, mut found) = (0.0, 0.5 * step, Vec::new());
    for (k, light) in lights.into_iter().enumerate().filter(|(_, light)| *light > 0.0) {
        gathered += light;
        if gathered > next {
            found.push((k % width, k / width));
            // A pixel that holds several shares is watched once.
            next += step * ((gathered - next) / step).ceil();
        }
    }
    found
}

/// What is stated of one mean, for one picture's value.
#[derive(Clone, Copy, Debug)]
struct Watched {
    /// W/m².
    due: f64,
    margin: f64,
    /// W²/m⁴.
    variance: f64,
}

/// What is stated, and by how many pictures it is tested.
pub(super) struct Plan {
    pub pictures: u64,
    places: BTreeMap<(usize, usize), usize>,
    points: Vec<MeasurementPoint>,
    pixels: Vec<Watched>,
    mean: Watched,
    has_map: bool,
}

/// What maps add to the variances. Each picture has its share of the rays, in groups that carry the same flux g.
struct OfMap<'a> {
    texels: &'a Texels,
    flux: f64,
    groups: f64,
}

impl<'a> OfMap<'a> {
    fn new(room: &Configuration, texels: &'a Texels, light: &LightSettings, pictures: u64) -> OfMap<'a> {
        let tracer = LightTracer::new(room, &share_of(light, pictures), 0);
        let groups = tracer.n_groups().max(1) as f64;
        OfMap { texels, flux: tracer.power() / groups, groups }
    }

    /// Of an irradiance E to which a group adds no more than g × `per_area`, and nothing less than nought: at most
    /// E (g × per_area − E / n), W²/m⁴.
    fn variance(&self, irradiance: f64, per_area: f64) -> f64 {
        (irradiance * (self.flux * per_area - irradiance / self.groups)).max(0.0)
    }
}

/// How rays are followed for one of so many pictures.
pub(super) fn share_of(light: &LightSettings, pictures: u64) -> LightSettings {
    LightSettings { rays: (light.rays / pictures).max(1), rings: None, ..light.clone() }
}

impl Plan {
    /// `Err`: why nothing can be stated.
    ///
    /// - `places`: columns and rows of the pixels to watch
    pub fn new(
        case: &Case,
        settings: &PictureSettings,
        view: &ReceiverView,
        places: &[(usize, usize)],
        due_at: impl Fn(usize, usize) -> Option<Due>,
        texels: Option<&Texels>,
        light: Option<&LightSettings>,
    ) -> Result<Plan, String> {
        let known = places.iter().filter_map(|(x, y)| {
            let point = view.element(*x as f64 + 0.5, *y as f64 + 0.5)?;
            due_at(*x, *y).map(|due| ((*x, *y), point, due))
        });
        let (mut places, mut points, mut dues) = (BTreeMap::new(), Vec::new(), Vec::new());
        for (place, point, due) in known {
            if let std::collections::btree_map::Entry::Vacant(free) = places.entry(place) {
                free.insert(points.len());
                points.push(point);
                dues.push(due);
            }
        }
        if points.is_empty() {
            return Err("no pixel has an exact value".to_owned());
        }
        let n = points.len() as f64;
        let weights = vec![vec![1.0 / n; points.len()]];
        let room = &case.configuration;
        let (mut direct, mut direct_mean) = (vec![0.0; points.len()], 0.0);
        if !room.sources().is_empty() {
            let contents = room.contents().clone();
            let arrangement = Arrangement::Scattered;
            let watched = Configuration::of(Contents { points: points.clone(), arrangement, ..contents })
                .map_err(|errors| format!("a watched pixel has no exact value: {}", errors[0]))?;
            let study =
                Study { strategies: vec![settings.strategy], samples: vec![settings.samples], ..case.study.clone() };
            let predictions = Predictions::new(&Oracle::new(&watched), &watched, &study, &weights, &[]);
            let cell = predictions.cell(settings.strategy, &study, 0, &weights);
            let unknown = || format!("the variance of {} is not predicted here", settings.strategy);
            for (variance, predicted) in direct.iter_mut().zip(&cell.points) {
                *variance = predicted.as_ref().ok_or_else(unknown)?.upper_variance();
            }
            direct_mean = cell.contrasts.as_ref().ok_or_else(unknown)?[0].upper_variance();
        }
        // What is due of the map: all that is due less the direct light, which has no part where there are no sources.
        let bent = |p: usize| texels.and_then(|texels| texels.at(&points[p])).unwrap_or_default();
        let stated = |pictures: u64| {
            let of_map = texels.zip(light).map(|(texels, light)| OfMap::new(room, texels, light, pictures));
            let pixels: Vec<Watched> = (0..points.len())
                .map(|p| {
                    let mut variance = direct[p];
                    if let Some(map) = &of_map {
                        let Bounded { value, bound } = bent(p);
                        variance += map.variance(value + bound, 1.0 / map.texels.area(map.texels.index(&points[p])));
                    }
                    let due = dues[p].irradiance;
                    Watched { due, margin: dues[p].bound + ROUNDING * due, variance }
                })
                .collect();
            let of_direct = |value: &dyn Fn(usize) -> f64| (0..points.len()).map(value).sum::<f64>() / n;
            let mut due = of_direct(&|p| (dues[p].irradiance - bent(p).value).max(0.0));
            let mut margin = of_direct(&|p| dues[p].bound);
            let mut variance = direct_mean;
            if let Some(map) = &of_map {
                let (all, area) = (map.texels.all(), map.texels.total_area());
                due += all.value;
                margin += all.bound;
                variance += map.variance(all.value + all.bound, 1.0 / area);
            }
            let mean = Watched { due, margin: margin + ROUNDING * due, variance };
            (pixels, mean)
        };
        let mut pictures = FEWEST;
        let (mut pixels, mut mean) = stated(pictures);
        let asked = COARSER * case.study.smallest_bias.mean;
        while pictures < MOST && seen(&mean, pictures, pixels.len() + 1) > asked * mean.due {
            pictures *= 2;
            (pixels, mean) = stated(pictures);
        }
        Ok(Plan { pictures, places, points, pixels, mean, has_map: texels.is_some() })
    }

    /// The number of a watched pixel.
    pub fn index_of(&self, x: usize, y: usize) -> Option<usize> {
        self.places.get(&(x, y)).copied()
    }

    /// Where the watched pixels are.
    pub fn points(&self) -> &[MeasurementPoint] {
        &self.points
    }

    pub fn judge(&self, sums: &Sums, case: &Case, settings: &PictureSettings) -> JudgedProperty {
        let components = self.pixels.len() + 1;
        let mut mean = PowerSums::about(self.mean.due);
        sums.means.iter().for_each(|value| mean.add(*value));
        let claims: Vec<(&Watched, &PowerSums)> =
            self.pixels.iter().zip(&sums.pixels).chain([(&self.mean, &mean)]).collect();
        let capital = |(watched, sums): &(&Watched, &PowerSums)| {
            let statement = Statement::near(watched.due, watched.margin, watched.variance);
            Capital::of(&statement, &Observed::values(sums), self.pictures).ln()
        };
        let capitals: Vec<f64> = claims.iter().map(capital).collect();
        let evidence = log10_capped(ln_average(capitals.iter().copied()));
        let relative =
            |watched: &Watched| (watched.due > 0.0).then(|| seen(watched, self.pictures, components) / watched.due);
        let in_mean = relative(&self.mean);
        let lit = self.pixels.iter().filter(|pixel| pixel.due >= WELL_LIT * self.mean.due);
        let worst = lit.filter_map(relative).reduce(f64::max);
        let asked = COARSER * case.study.smallest_bias.mean;
        let verdict = if evidence >= THRESHOLD_LOG10 {
            Verdict::Fail
        } else if in_mean.is_none_or(|seen| seen <= asked * (1.0 + 1e-9)) {
            Verdict::Pass
        } else {
            Verdict::Undecided
        };
        let strongest = (0..claims.len()).max_by(|a, b| capitals[*a].total_cmp(&capitals[*b])).unwrap_or(0);
        let shown = if verdict == Verdict::Fail { strongest } else { self.pixels.len() };
        let (watched, values) = claims[shown];
        let scale = [watched.due, self.mean.due].into_iter().find(|due| *due > 0.0).unwrap_or(1.0);
        let effect = values.mean_deviation().unwrap_or(0.0) / scale;
        let error = values.std_error().unwrap_or(0.0) / scale;
        let n = self.pixels.len();
        let mean_of = if self.has_map {
            format!("the mean of {n} pixels and the map")
        } else {
            format!("the mean of {n} pixels")
        };
        let place = self.places.iter().find(|(_, index)| **index == shown);
        let place = match place {
            Some(((x, y), _)) if watched.due > 0.0 => format!("in pixel ({x}, {y})"),
            Some(((x, y), _)) => format!("of the mean in pixel ({x}, {y}), where nothing is due"),
            None => format!("in {mean_of}"),
        };
        let percent = |x: Option<f64>| x.map_or("nothing".to_owned(), |x| format!("{:.2} %", 100.0 * x));
        let bar = format!("{} at the worst well-lit one", percent(worst));
        let words = match verdict {
            Verdict::Fail => format!(
                "the picture is off by {:+.2} % ± {:.2} % {place}, over {} pictures",
                100.0 * effect,
                100.0 * Z_95 * error,
                self.pictures
            ),
            Verdict::Pass if in_mean.is_none() => {
                "no light is due in the watched pixels, and none arrived".to_owned()
            }
            Verdict::Pass => format!(
                "no deviation above {} in {mean_of}, {bar}, over {} pictures",
                percent(in_mean),
                self.pictures
            ),
            Verdict::Undecided => format!(
                "too little light: a deviation of {} in {mean_of} would have been seen ({} asked), {bar}",
                percent(in_mean),
                percent(Some(asked))
            ),
        };
        JudgedProperty {
            property: "picture",
            verdict,
            evidence,
            threshold: THRESHOLD_LOG10,
            effect,
            effect_low: effect - Z_95 * error,
            effect_high: effect + Z_95 * error,
            smallest_bias_mean: in_mean,
            smallest_bias_point: worst,
            words,
            note: None,
            reproduce: settings.command(&case.selector) + case.reach.words(),
        }
    }
}

/// The deviation that would have been caught, W/m².
fn seen(watched: &Watched, pictures: u64, components: usize) -> f64 {
    smallest_shift(watched.variance, pictures, components) + watched.margin
}

/// Values of the watched pixels over all pictures.
pub(super) struct Sums {
    pixels: Vec<PowerSums>,
    /// The mean that is judged, one for each picture, W/m².
    means: Vec<f64>,
}

impl Sums {
    pub fn new(plan: &Plan) -> Sums {
        Sums {
            pixels: plan.pixels.iter().map(|pixel| PowerSums::about(pixel.due)).collect(),
            means: vec![0.0; plan.pictures as usize],
        }
    }
    /// What pictures show in a watched pixel: direct light, and that plus the map's; one for each picture, W/m².
    pub fn add(&mut self, pixel: usize, direct: &[f64], values: &[f64]) {
        let n = self.pixels.len() as f64;
        for ((direct, value), mean) in direct.iter().zip(values).zip(&mut self.means) {
            self.pixels[pixel].add(*value);
            *mean += direct / n;
        }
    }
    /// The mean over the map in each picture, W/m².
    pub fn add_map(&mut self, of_pictures: &[f64]) {
        self.means.iter_mut().zip(of_pictures).for_each(|(mean, map)| *mean += map);
    }
}
