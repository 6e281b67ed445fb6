//! The pictures that the lecture shows, made from shipped cases.

use thiserror::Error;

use super::picture::{PictureSettings, ReceiverPicture, camera_picture, receiver_picture};
use crate::case::{Case, CaseErrors, Shipped, shipped};
use crate::configuration::Configuration;
use crate::eye::{Caustics, Direct, Eye, EyeError, Picture, View};
use crate::light::trace;
use crate::sampling::Strategy;

/// Why a picture of the lecture cannot be made: a fault of this program, whose own cases they show.
#[derive(Debug, Error)]
pub enum LectureError {
    #[error(transparent)]
    Case(#[from] CaseErrors),
    #[error(transparent)]
    Eye(#[from] EyeError),
    #[error("the case {name} is no longer shipped, or has no camera")]
    Missing { name: &'static str },
}

/// All of them.
#[derive(Clone, Debug)]
pub struct Lecture {
    /// The eclipse: from aside, and its receiver with all that is known of it.
    pub shadow: (Picture, ReceiverPicture),
    /// The same receiver by each strategy at each number of points.
    pub strategies: Vec<(Strategy, u64, ReceiverPicture)>,
    pub textures: Textures,
    pub caustics: Vec<Caustic>,
}

/// What distortion does to a map, and what undoes it.
#[derive(Clone, Debug)]
pub struct Textures {
    /// A ball with a chessboard of albedo.
    pub ball: Picture,
    /// A chessboard on a triangle by half of the square, and by a triangle similar to it.
    pub triangle: [Picture; 2],
    /// A caustic at the pole of a globe: texels taken as of equal area, and by their exact areas.
    pub globe: [Picture; 2],
}

/// A caustic on a plane, from aside and square on.
#[derive(Clone, Debug)]
pub struct Caustic {
    pub title: String,
    pub name: &'static str,
    pub aside: Picture,
    pub receiver: ReceiverPicture,
}

/// The numbers of points of the comparison.
const SAMPLES: [u64; 3] = [4, 16, 64];
/// Pictures from aside have more pixels than they are shown with, so that edges are smooth.
const FINE: [usize; 2] = [1280, 960];
/// Times the rays of the case, for a caustic without visible noise.
const MORE_RAYS: u64 = 4;
const SHOWN_CAUSTICS: [&str; 3] = ["caustic/mirror-ring", "caustic/ball-on-a-table", "caustic/cup"];

/// Makes all pictures of the lecture.
pub fn lecture(seed: u64) -> Result<Lecture, LectureError> {
    let fine = PictureSettings { samples: 64, seed, ..PictureSettings::default() };
    let eclipse = read("penumbra/eclipse")?;
    let large = PictureSettings { pixels: Some([512, 512]), ..fine.clone() };
    let shadow = (aside(&eclipse, "penumbra/eclipse", &fine)?, receiver_picture(&eclipse, &large)?);
    let mut strategies = Vec::new();
    for strategy in Strategy::LECTURE {
        for samples in SAMPLES {
            let settings = PictureSettings { strategy, samples, seed, pixels: Some([160, 160]) };
            strategies.push((strategy, samples, receiver_picture(&eclipse, &settings)?));
        }
    }
    let mut caustics = Vec::new();
    for name in SHOWN_CAUSTICS {
        let mut case = read(name)?;
        case.light.rays = case.light.rays.saturating_mul(MORE_RAYS);
        caustics.push(Caustic {
            title: case.title.clone(),
            name,
            aside: aside(&case, name, &fine)?,
            receiver: receiver_picture(&case, &fine)?,
        });
    }
    Ok(Lecture { shadow, strategies, textures: textures(&fine)?, caustics })
}

fn textures(settings: &PictureSettings) -> Result<Textures, LectureError> {
    let ball = aside(&read("texture/tiled-ball")?, "texture/tiled-ball", settings)?;
    const TRIANGLE: &str = "texture/slanted-triangle";
    let similar = read(TRIANGLE)?;
    let sheared = find(TRIANGLE)?.text().replace("map = \"similar\"", "map = \"half-square\"");
    let sheared = Case::from_toml("sheared", &sheared)?;
    let triangle = [aside(&sheared, TRIANGLE, settings)?, aside(&similar, TRIANGLE, settings)?];

    const GLOBE: &str = "caustic/ball-on-a-globe";
    let globe = read(GLOBE)?;
    let room: &Configuration = &globe.configuration;
    let camera = globe.camera.ok_or(LectureError::Missing { name: GLOBE })?;
    let light =
        crate::light::LightSettings { rays: globe.light.rays.saturating_mul(MORE_RAYS), ..globe.light.clone() };
    let run = trace(room, &light, settings.seed);
    let eye = Eye::new(room, View::Camera(camera.with_pixels(FINE).map_err(EyeError::Camera)?), Direct::new(room))?;
    let by = |caustics: Caustics| eye.picture(&settings.shading(), &caustics);
    let globe = [by(Caustics::as_if_even(&run.maps)), by(Caustics::by_texel(&run.maps))];
    Ok(Textures { ball, triangle, globe })
}

fn find(name: &'static str) -> Result<Shipped, LectureError> {
    shipped().find(|case| case.name() == name).ok_or(LectureError::Missing { name })
}

fn read(name: &'static str) -> Result<Case, LectureError> {
    Ok(find(name)?.read()?)
}

fn aside(case: &Case, name: &'static str, settings: &PictureSettings) -> Result<Picture, LectureError> {
    camera_picture(case, &PictureSettings { pixels: Some(FINE), ..settings.clone() })?
        .ok_or(LectureError::Missing { name })
}
