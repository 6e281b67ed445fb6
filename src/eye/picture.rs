//! Pictures: rows of pixels, each a pure function of its place and the seed.

use rayon::prelude::*;

use super::direct::Direct;
use super::error::EyeError;
use super::view::View;
use crate::configuration::{Configuration, MeasurementPoint, Receiver};
use crate::estimator::{Estimator, Scratch};
use crate::geometry::DVec3;
use crate::light::{First, Light, Seen, Sight, Sighting, TexelMap};
use crate::sampling::Strategy;

/// How direct light is estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    pub strategy: Strategy,
    /// N ≥ 1 points on each source for each pixel.
    pub samples: u64,
    pub seed: u64,
}

/// What the maps of rays from the light add to a surface.
#[derive(Clone, Copy)]
pub struct Caustics<'a> {
    maps: &'a [TexelMap],
    lookup: Lookup,
}

#[derive(Clone, Copy)]
enum Lookup {
    Texel,
    Smooth,
    AsIfEven,
}

impl<'a> Caustics<'a> {
    /// Nothing is bent.
    pub fn none() -> Caustics<'static> {
        Caustics { maps: &[], lookup: Lookup::Texel }
    }
    /// Each texel even, as it is measured: flux over exact area.
    pub fn by_texel(maps: &'a [TexelMap]) -> Caustics<'a> {
        Caustics { maps, lookup: Lookup::Texel }
    }
    /// Interpolated between texels, which keeps the flux.
    pub fn smooth(maps: &'a [TexelMap]) -> Caustics<'a> {
        Caustics { maps, lookup: Lookup::Smooth }
    }
    /// A mistake to be shown: flux over the mean area of all texels, as if the map were not distorted.
    pub fn as_if_even(maps: &'a [TexelMap]) -> Caustics<'a> {
        Caustics { maps, lookup: Lookup::AsIfEven }
    }
    /// W/m²; nought where the surface has no map.
    pub fn irradiance(&self, surface: usize, at: DVec3, light: Light) -> f64 {
        let Some(map) = self.maps.get(surface) else { return 0.0 };
        match self.lookup {
            Lookup::Texel => map.nearest(at, light).watts_per_square_metre(),
            Lookup::Smooth => map.interpolated(at, light).watts_per_square_metre(),
            Lookup::AsIfEven => {
                let texel = map.grid().texel(map.parametrisation().to_map(at));
                let mean_area = map.parametrisation().area() / map.grid().n_texels() as f64;
                map.moments(texel, light).watts() / mean_area
            }
        }
    }
}

/// A scattering surface in a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Column.
    pub pixel: usize,
    /// The receiver (0, if there is one), then the diffuse surfaces.
    pub surface: usize,
    pub point: MeasurementPoint,
    /// What the pixel gets of its radiosity, in [0, 1].
    pub share: f64,
    /// Whether it is seen straight, and is all of the pixel.
    pub is_straight: bool,
}

/// What a row of pixels sees, before any light is estimated.
#[derive(Clone, Debug)]
pub struct RowSight {
    pub row: usize,
    /// By surface, then by column.
    pub spots: Vec<Spot>,
    /// π × radiance of what shines by itself, W/m², by column.
    pub emitted: Vec<f64>,
    /// What is met first, by column.
    pub first: Vec<First>,
}

/// One pixel of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// π × radiance, W/m²: the radiosity (or exitance) of what is seen.
    pub radiosity: f64,
    pub first: First,
    /// Where a scattering surface is seen straight.
    pub lit: Option<Lit>,
}

/// The light on a surface in a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    /// The receiver (0, if there is one), then the diffuse surfaces.
    pub surface: usize,
    pub point: MeasurementPoint,
    /// Straight from sources and lamps, W/m².
    pub direct: f64,
    /// By way of mirrors and glass, W/m².
    pub caustic: f64,
    /// Looked up at the point; 1 where the surface has none (irradiance is then shown as it is).
    pub albedo: f64,
}

impl Lit {
    /// W/m².
    pub fn irradiance(&self) -> f64 {
        self.direct + self.caustic
    }
}

/// A picture. The same for any number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    /// Row by row from the top, each from the left.
    pixels: Vec<Pixel>,
}

impl Picture {
    /// - `pixels`: `[height][width]`, from the upper left corner; as many as width × height
    pub fn new([width, height]: [usize; 2], pixels: Vec<Pixel>) -> Picture {
        assert_eq!(pixels.len(), width * height, "{width} × {height} pixels");
        Picture { width, height, pixels }
    }
    pub fn width(&self) -> usize {
        self.width
    }
    pub fn height(&self) -> usize {
        self.height
    }
    /// - `x`, `y`: column and row from the upper left corner, within the picture
    pub fn pixel(&self, x: usize, y: usize) -> &Pixel {
        &self.pixels[y * self.width + x]
    }
    /// Row by row from the top.
    pub fn pixels(&self) -> &[Pixel] {
        &self.pixels
    }
}

/// A room, a view of it, and the light in it.
pub struct Eye {
    room: Configuration,
    view: View,
    sight: Sight,
    direct: Direct,
}

impl Eye {
    /// - `direct`: of the same room; of another, the picture shows what that gets wrong
    pub fn new(room: &Configuration, view: View, direct: Direct) -> Result<Eye, EyeError> {
        view.stands_free(room)?;
        Ok(Eye { room: room.clone(), view, sight: Sight::new(room), direct })
    }

    pub fn view(&self) -> &View {
        &self.view
    }
    pub fn direct(&self) -> &Direct {
        &self.direct
    }

    /// What one row of pixels sees, from the top.
    pub fn row(&self, row: usize) -> RowSight {
        let [width, _] = self.view.pixels();
        let mut seen = RowSight {
            row,
            spots: Vec::with_capacity(width),
            emitted: vec![0.0; width],
            first: vec![First::Nothing; width],
        };
        let mut ends = Vec::new();
        for pixel in 0..width {
            let (x, y) = (pixel as f64 + 0.5, row as f64 + 0.5);
            match &self.view {
                View::Receiver(view) => {
                    let Some(point) = view.element(x, y) else { continue };
                    seen.first[pixel] = First::Surface;
                    seen.spots.push(Spot { pixel, surface: 0, point, share: 1.0, is_straight: true });
                }
                View::Camera(camera) => {
                    let (from, direction) = camera.ray(x, y);
                    seen.first[pixel] = self.sight.follow(from, direction, &mut ends);
                    ends.iter().for_each(|end| self.note(end, pixel, &mut seen));
                }
            }
        }
        seen.spots.sort_by_key(|spot| spot.surface);
        seen
    }

    fn note(&self, end: &Sighting, pixel: usize, seen: &mut RowSight) {
        match end.seen {
            Seen::Source(source) => {
                let exitance = self.room.contents().sources[source].exitance_at(end.at);
                seen.emitted[pixel] += end.share * exitance.watts_per_square_metre();
            }
            Seen::Surface(surface) => {
                if let Some(diffuse) = self.diffuse(surface) {
                    seen.emitted[pixel] += end.share * diffuse.exitance().watts_per_square_metre();
                }
                if let Ok(point) = MeasurementPoint::new(end.at, end.normal) {
                    let (share, is_straight) = (end.share, end.is_straight);
                    seen.spots.push(Spot { pixel, surface, point, share, is_straight });
                }
            }
            Seen::Nothing | Seen::Black | Seen::Lost => {}
        }
    }

    fn diffuse(&self, surface: usize) -> Option<&crate::configuration::DiffuseSurface> {
        let before = usize::from(self.room.receiver().is_some());
        surface.checked_sub(before).map(|index| &self.room.diffuse()[index])
    }

    /// At a point of a surface; 1 where it has none.
    fn albedo(&self, surface: usize, at: DVec3) -> f64 {
        match self.diffuse(surface) {
            Some(diffuse) => diffuse.albedo().ratio(),
            None => {
                let of_receiver = |receiver: &Receiver| receiver.albedo_at(at);
                self.room.receiver().and_then(of_receiver).map_or(1.0, |albedo| albedo.ratio())
            }
        }
    }

    /// Which light of the maps a surface takes.
    pub fn light_from_maps(&self, surface: usize) -> Light {
        if self.direct.is_from_map(surface) { Light::Both } else { Light::Bent }
    }

    /// Estimators of all surfaces, for [`Eye::direct_light`].
    pub fn estimators(&self, shading: &Shading) -> Vec<Option<Box<dyn Estimator>>> {
        self.direct.estimators(shading)
    }

    /// Direct irradiance at the spots of a row, W/m²: `[spot][replicate]`. Replicates are independent pictures.
    pub fn direct_light(
        &self,
        estimators: &[Option<Box<dyn Estimator>>],
        seen: &RowSight,
        shading: &Shading,
        replicates: std::ops::Range<u64>,
        scratch: &mut Scratch,
    ) -> Vec<f64> {
        let mut all = Vec::new();
        for spots in seen.spots.chunk_by(|a, b| a.surface == b.surface) {
            let points: Vec<MeasurementPoint> = spots.iter().map(|spot| spot.point).collect();
            let (surface, replicates) = (spots[0].surface, replicates.clone());
            all.extend(self.direct.irradiance(estimators, surface, seen.row, &points, shading, replicates, scratch));
        }
        all
    }

    /// A row's pixels, from the direct light at its spots.
    ///
    /// - `direct`: W/m², one for each spot; `caustic`: W/m², at a spot
    pub fn pixels(&self, seen: &RowSight, direct: &[f64], caustic: impl Fn(&Spot) -> f64) -> Vec<Pixel> {
        let emitted = seen.emitted.iter().zip(&seen.first);
        let mut pixels: Vec<Pixel> =
            emitted.map(|(emitted, first)| Pixel { radiosity: *emitted, first: *first, lit: None }).collect();
        for (spot, direct) in seen.spots.iter().zip(direct) {
            let albedo = self.albedo(spot.surface, spot.point.position());
            let lit =
                Lit { surface: spot.surface, point: spot.point, direct: *direct, caustic: caustic(spot), albedo };
            let pixel = &mut pixels[spot.pixel];
            pixel.radiosity += spot.share * albedo * lit.irradiance();
            if spot.is_straight {
                pixel.lit = Some(lit);
            }
        }
        pixels
    }

    /// The picture.
    pub fn picture(&self, shading: &Shading, caustics: &Caustics) -> Picture {
        let [width, height] = self.view.pixels();
        let estimators = self.estimators(shading);
        let row = |row: usize, scratch: &mut Scratch| {
            let seen = self.row(row);
            let direct = self.direct_light(&estimators, &seen, shading, 0..1, scratch);
            self.pixels(&seen, &direct, |spot| {
                caustics.irradiance(spot.surface, spot.point.position(), self.light_from_maps(spot.surface))
            })
        };
        let rows: Vec<Vec<Pixel>> =
            (0..height).into_par_iter().map_init(Scratch::default, |scratch, k| row(k, scratch)).collect();
        Picture::new([width, height], rows.into_iter().flatten().collect())
    }
}
