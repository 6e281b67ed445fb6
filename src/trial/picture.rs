//! Pictures against the exact side: what each pixel should show, how far it is off, and one verdict on all of it.
//!
//! A case's receiver is seen square on and rendered K times, with streams and maps of their own each time: K independent
//! pictures. A pixel shows direct light at its middle and the map's texel around it, so what is due there is the exact
//! irradiance at the middle plus the exact mean of the bent light over that texel. The gate judges up to 144 pixels spread over
//! the picture, each by its K values, and their mean: the statement is that these have the mean that is due, and the variance
//! that the exact side predicts (direct light) or that follows from equal packets of flux (the map's).

mod bent;
mod judge;

use std::collections::BTreeMap;

use rayon::prelude::*;

use self::bent::{Bent, Texels};
use self::judge::{Plan, Sums};
use super::outcome::JudgedProperty;
use crate::case::Case;
use crate::configuration::{Configuration, MeasurementPoint};
use crate::estimator::Scratch;
use crate::eye::{Caustics, Direct, Eye, EyeError, Picture, Pixel, ReceiverView, Shading, View};
use crate::geometry::{Texel, TexelGrid};
use crate::light::{LightSettings, trace};
use crate::oracle::{Method, Oracle, Region};
use crate::sampling::{Strategy, Stream, StreamKey};

/// Longer side of a receiver's picture where nothing is said, pixels.
const LONGEST: usize = 256;
/// Exact values by quadrature take long: along the longer side no more than these are made.
const MOST_BY_QUADRATURE: usize = 40;
/// Keeps the maps' streams apart from those of other runs: "picture" in ASCII.
const PURPOSE: u64 = 0x0070_6963_7475_7265;

/// How pictures are made.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSettings {
    pub strategy: Strategy,
    /// Points on each source for each pixel, ≥ 1.
    pub samples: u64,
    pub seed: u64,
    /// Width and height; `None`: the camera's own, and 256 along the longer side of a receiver.
    pub pixels: Option<[usize; 2]>,
}

impl Default for PictureSettings {
    fn default() -> PictureSettings {
        PictureSettings { strategy: Strategy::Stratified, samples: 16, seed: 1, pixels: None }
    }
}

impl PictureSettings {
    /// The command that gives the same pictures.
    pub fn command(&self, case: &str) -> String {
        let PictureSettings { strategy, samples, seed, pixels } = self;
        let size = pixels.map_or(String::new(), |[width, height]| format!(" --size {width}x{height}"));
        let case = super::settings::quoted(case);
        format!("etendue render {case} --strategy {strategy} --samples {samples}{size} --seed {seed}")
    }
    /// The same for [`crate::eye`].
    pub fn shading(&self) -> Shading {
        Shading { strategy: self.strategy, samples: self.samples, seed: self.seed }
    }
}

/// What is due in a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Due {
    /// W/m².
    pub irradiance: f64,
    /// It is off by no more than this, W/m².
    pub bound: f64,
    /// How much of the sources with area is seen; `None` where there are none.
    pub region: Option<Region>,
}

/// Whether a picture was judged.
#[derive(Clone, Debug, PartialEq)]
pub enum Judged {
    By(JudgedProperty),
    /// Why it was not.
    Not(String),
}

/// The picture of a receiver, and what is known of it.
#[derive(Clone, Debug)]
pub struct ReceiverPicture {
    pub case: String,
    pub title: String,
    pub settings: PictureSettings,
    pub view: ReceiverView,
    /// The first of the pictures; its bent light is that of all of them together.
    pub picture: Picture,
    /// K: independent pictures that were made.
    pub pictures: u64,
    /// How rays were followed from the light, all pictures together; `None` where none were needed.
    pub light: Option<LightSettings>,
    /// `[height][width]`; `None` where it is not known, beside the receiver, and between the pixels of the stride.
    pub due: Vec<Option<Due>>,
    /// Standard error of each pixel's irradiance, by the spread over all pictures, W/m²; `None` beside the receiver.
    pub std_error: Vec<Option<f64>>,
    /// Exact values are made for one pixel in so many along either side, the middle one.
    pub stride: usize,
    pub judged: Judged,
}

impl ReceiverPicture {
    /// What is due in the block of the stride that a pixel lies in, and the pixel in its middle.
    pub fn due_around(&self, x: usize, y: usize) -> Option<(usize, Due)> {
        let [width, height] = self.view.pixels();
        let middle = |k: usize, n: usize| (k - k % self.stride + self.stride / 2).min(n - 1);
        let index = middle(y, height) * width + middle(x, width);
        self.due[index].map(|due| (index, due))
    }
    /// Shown less due, W/m², in that middle pixel.
    pub fn error_around(&self, x: usize, y: usize) -> Option<f64> {
        let (index, due) = self.due_around(x, y)?;
        self.picture.pixels()[index].lit.map(|lit| lit.irradiance() - due.irradiance)
    }
    /// The error in standard errors; `None` too where no picture differs from another.
    pub fn z_around(&self, x: usize, y: usize) -> Option<f64> {
        let (index, _) = self.due_around(x, y)?;
        let std_error = self.std_error[index].filter(|std_error| *std_error > 0.0)?;
        self.error_around(x, y).map(|error| error / std_error)
    }
}

/// What the camera of a case sees; `None` where it has none. Bent light is interpolated between texels.
pub fn camera_picture(case: &Case, settings: &PictureSettings) -> Result<Option<Picture>, EyeError> {
    let Some(camera) = case.camera else { return Ok(None) };
    let view = View::Camera(match settings.pixels {
        Some(pixels) => camera.with_pixels(pixels)?,
        None => camera,
    });
    let room = &case.configuration;
    let eye = Eye::new(room, view, Direct::new(room))?;
    if !needs_maps(room, &eye) {
        return Ok(Some(eye.picture(&settings.shading(), &Caustics::none())));
    }
    let run = trace(room, &case.light, settings.seed);
    Ok(Some(eye.picture(&settings.shading(), &Caustics::smooth(&run.maps))))
}

fn needs_maps(room: &Configuration, eye: &Eye) -> bool {
    let surfaces = usize::from(room.receiver().is_some()) + room.diffuse().len();
    room.has_optics() || (0..surfaces).any(|surface| eye.direct().is_from_map(surface))
}

/// The receiver of a case, rendered and judged.
pub fn receiver_picture(case: &Case, settings: &PictureSettings) -> Result<ReceiverPicture, EyeError> {
    receiver_picture_with(case, settings, Direct::new(&case.configuration))
}

/// The same with a direct term of the caller's: what is judged is the sum of that and the map.
pub fn receiver_picture_with(
    case: &Case,
    settings: &PictureSettings,
    direct: Direct,
) -> Result<ReceiverPicture, EyeError> {
    let room = &case.configuration;
    let view = View::of_receiver(room, LONGEST)?;
    let view = match settings.pixels {
        Some(pixels) => view.with_pixels(pixels)?,
        None => view,
    };
    let eye = Eye::new(room, view, direct)?;
    let View::Receiver(of_receiver) = view else { return Err(EyeError::NoReceiver) };
    let [width, height] = view.pixels();

    let bent = Bent::of(room, &eye);
    let light = needs_maps(room, &eye).then(|| bent.settings(&case.light));
    let texels = light.as_ref().and_then(|light| bent.over_texels(room, light.map)).filter(Texels::is_complete);
    let is_known = match (&bent, &light) {
        (Bent::Unknown(_), _) => false,
        (_, Some(_)) => texels.is_some(),
        (_, None) => true,
    };
    let oracle = Oracle::new(room);
    let lattice = judge::lattice(&of_receiver);
    let by_quadrature = |(x, y): &(usize, usize)| {
        let element = of_receiver.element(*x as f64 + 0.5, *y as f64 + 0.5);
        element.is_some_and(|point| oracle.at(&point).method == Method::Quadrature)
    };
    let slow = is_known && !room.sources().is_empty() && lattice.iter().any(by_quadrature);
    let stride = if slow { width.max(height).div_ceil(MOST_BY_QUADRATURE) } else { 1 };

    let why_not = match &bent {
        Bent::Unknown(why) => Some((*why).to_owned()),
        _ if !is_known => Some("the mean of bent light over this map's texels has no exact value".to_owned()),
        _ => None,
    };
    let due_at = |x: usize, y: usize| -> Option<Due> {
        let point = of_receiver.element(x as f64 + 0.5, y as f64 + 0.5).filter(|_| is_known)?;
        let (mut irradiance, mut bound, mut region) = (0.0, 0.0, None);
        if !room.sources().is_empty() {
            let truth = oracle.at(&point);
            irradiance = truth.irradiance.watts_per_square_metre();
            bound = truth.bound.watts_per_square_metre();
            region = Some(truth.region);
        }
        if let Some(texels) = &texels {
            let mean = texels.at(&point)?;
            irradiance += mean.value;
            bound += mean.bound;
        }
        Some(Due { irradiance, bound, region })
    };
    let mut places = lattice;
    places.extend(texels.iter().flat_map(|texels| judge::bright(&of_receiver, texels)));
    let plan = match why_not {
        Some(why) => Err(why),
        None => Plan::new(case, settings, &of_receiver, &places, due_at, texels.as_ref(), light.as_ref()),
    };
    let pictures = plan.as_ref().map_or(judge::FEWEST, |plan| plan.pictures);

    let watched = plan.as_ref().map_or(&[][..], Plan::points);
    let maps = light.as_ref().map(|light| Maps::trace(room, light, &eye, settings.seed, pictures, watched));
    let mut sums = plan.as_ref().ok().map(Sums::new);
    if let (Some(sums), Some(maps)) = (&mut sums, &maps) {
        sums.add_map(&maps.means);
    }
    let shading = settings.shading();
    let estimators = eye.estimators(&shading);
    let row = |y: usize, scratch: &mut Scratch| {
        let seen = eye.row(y);
        let direct = eye.direct_light(&estimators, &seen, &shading, 0..pictures, scratch);
        let k = pictures as usize;
        let first: Vec<f64> = direct.chunks(k).map(|values| values[0]).collect();
        let bent_light = |at| maps.as_ref().map_or(0.0, |maps: &Maps| maps.mean(at));
        let pixels = eye.pixels(&seen, &first, |spot| bent_light(spot.point.position()));
        let mut std_errors = vec![None; width];
        let mut watched = Vec::new();
        for (spot, values) in seen.spots.iter().zip(direct.chunks(k)) {
            let of_map = maps.as_ref().map_or(0.0, |maps| maps.variance_of_mean(spot.point.position()));
            std_errors[spot.pixel] = Some((variance(values) + of_map).sqrt());
            if let Some(index) = plan.as_ref().ok().and_then(|plan| plan.index_of(spot.pixel, y)) {
                let of_picture = |(picture, direct): (usize, &f64)| {
                    direct + maps.as_ref().map_or(0.0, |maps| maps.of_picture(picture, spot.point.position()))
                };
                let shown: Vec<f64> = values.iter().enumerate().map(of_picture).collect();
                watched.push((index, values.to_vec(), shown));
            }
        }
        let due: Vec<Option<Due>> = (0..width)
            .map(|x| {
                let middle = |k: usize, n: usize| k == (k - k % stride + stride / 2).min(n - 1);
                (middle(x, width) && middle(y, height)).then(|| due_at(x, y)).flatten()
            })
            .collect();
        (pixels, std_errors, watched, due)
    };
    let rows: Vec<_> = (0..height).into_par_iter().map_init(Scratch::default, |scratch, y| row(y, scratch)).collect();

    let mut pixels: Vec<Pixel> = Vec::with_capacity(width * height);
    let (mut std_error, mut due) = (Vec::with_capacity(width * height), Vec::with_capacity(width * height));
    for (of_row, errors, watched, exact) in rows {
        pixels.extend(of_row);
        std_error.extend(errors);
        due.extend(exact);
        if let Some(sums) = &mut sums {
            watched.into_iter().for_each(|(index, direct, shown)| sums.add(index, &direct, &shown));
        }
    }
    let judged = match (&plan, &sums) {
        (Ok(plan), Some(sums)) => Judged::By(plan.judge(sums, case, settings)),
        (Err(why), _) => Judged::Not(why.clone()),
        _ => Judged::Not("nothing was watched".to_owned()),
    };
    Ok(ReceiverPicture {
        case: case.name.clone(),
        title: case.title.clone(),
        settings: settings.clone(),
        view: of_receiver,
        picture: Picture::new([width, height], pixels),
        pictures,
        light,
        due,
        std_error,
        stride,
        judged,
    })
}

/// Of one of them, by the spread of all (divisor n − 1).
fn variance(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / (n - 1.0).max(1.0)
}

/// The receiver's maps of all pictures: what they hold in every texel, together.
struct Maps {
    map: crate::geometry::Parametrisation,
    grid: TexelGrid,
    /// Σ and Σ² over pictures of each texel's irradiance, W/m².
    sums: Vec<[f64; 2]>,
    /// Of texels that are watched: one value for each picture, W/m².
    watched: BTreeMap<usize, Vec<f64>>,
    /// The mean over the whole map in each picture, W/m².
    means: Vec<f64>,
    pictures: u64,
}

impl Maps {
    /// - `light`: its rays are shared among the pictures; `watched`: points whose texels are kept picture by picture
    fn trace(
        room: &Configuration,
        light: &LightSettings,
        eye: &Eye,
        seed: u64,
        pictures: u64,
        watched: &[MeasurementPoint],
    ) -> Maps {
        let kind = eye.light_from_maps(0);
        let settings = judge::share_of(light, pictures);
        let mut maps: Option<Maps> = None;
        for picture in 0..pictures {
            let run = trace(room, &settings, seed_of_map(seed, picture));
            let Some(map) = run.maps.first() else { continue };
            let maps = maps.get_or_insert_with(|| {
                let (chart, grid) = (*map.parametrisation(), map.grid());
                let texel = |point: &MeasurementPoint| grid.index(grid.texel(chart.to_map(point.position())));
                Maps {
                    map: chart,
                    grid,
                    sums: vec![[0.0; 2]; grid.n_texels()],
                    watched: watched.iter().map(|point| (texel(point), Vec::new())).collect(),
                    means: Vec::new(),
                    pictures,
                }
            });
            maps.means.push(map.total(kind) / map.parametrisation().area());
            for texel in map.grid().texels() {
                let index = map.grid().index(texel);
                let value = map.irradiance(texel, kind).unwrap_or_default().watts_per_square_metre();
                maps.sums[index][0] += value;
                maps.sums[index][1] += value * value;
                if let Some(values) = maps.watched.get_mut(&index) {
                    values.push(value);
                }
            }
        }
        maps.expect("there is a receiver, and at least one picture")
    }

    fn texel(&self, at: crate::geometry::DVec3) -> Texel {
        self.grid.texel(self.map.to_map(at))
    }
    fn mean(&self, at: crate::geometry::DVec3) -> f64 {
        self.sums[self.grid.index(self.texel(at))][0] / self.pictures as f64
    }
    fn variance_of_mean(&self, at: crate::geometry::DVec3) -> f64 {
        let ([sum, squares], n) = (self.sums[self.grid.index(self.texel(at))], self.pictures as f64);
        ((squares - sum * sum / n) / (n - 1.0).max(1.0) / n).max(0.0)
    }
    fn of_picture(&self, picture: usize, at: crate::geometry::DVec3) -> f64 {
        let values = self.watched.get(&self.grid.index(self.texel(at)));
        values.and_then(|values| values.get(picture)).copied().unwrap_or(0.0)
    }
}

/// Another for each picture.
fn seed_of_map(seed: u64, picture: u64) -> u64 {
    use rand::RngExt;
    Stream::new(StreamKey::root(seed).with(PURPOSE).with(picture)).random()
}
