//! What the pixels of a rendered case are: the manifest that an exported scene carries with it.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::pixels::PixelGrid;
use crate::configuration::Configuration;
use crate::intake::IMAGE_MANIFEST;

/// Seeds of independent images: the first, and what is added for the next. Neighbouring seeds share streams in some
/// renderers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Seeds {
    pub first: u64,
    pub spacing: u64,
}

/// What a scene's images are images of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    pub schema_version: u32,
    /// Who wrote it, with version.
    pub generator: String,
    /// Whose scene it is.
    pub renderer: String,
    pub case: String,
    /// Of the case's physical content.
    pub digest: String,
    pub units: String,
    /// Exitance of each source, M, W/m².
    pub exitance: Vec<f64>,
    /// Radiance of each source, L = M/π, W/(m² sr).
    pub radiance: Vec<f64>,
    /// Reflectance of the receiver in the scene, ρ.
    pub rho: f64,
    pub pixels: PixelGrid,
    /// Surfaces that light meets on its way at most, the source being the first: 2, direct light; 3, by a mirror, too; 4, by a ball of glass.
    pub depth: u32,
    pub filter: String,
    /// Whether the first of a pixel's samples looks at its middle, whatever the seed: then the mean over images is
    /// (mean over the footprint · (N − 1) + value in the middle)/N.
    #[serde(default)]
    pub first_sample_at_centre: bool,
    pub component_format: String,
    pub channels: Vec<String>,
    pub samples_per_pixel: u64,
    pub seeds: Seeds,
    /// What turns a pixel into irradiance.
    pub formula: String,
}

impl Manifest {
    pub const SCHEMA_VERSION: u32 = 1;
    pub const FORMULA: &'static str = "E = pi L / rho";
    pub const UNITS: &'static str = "metres; radiance L in W/(m2 sr); irradiance E and exitance M in W/m2";

    /// Reads a manifest, and holds it against the case.
    pub fn read(path: &Path, configuration: &Configuration) -> Result<Manifest, ManifestError> {
        use std::io::Read;
        let unreadable = |source| ManifestError::Unreadable { path: path.to_owned(), source };
        let mut text = String::new();
        let file = std::fs::File::open(path).map_err(unreadable)?;
        file.take(IMAGE_MANIFEST + 1).read_to_string(&mut text).map_err(unreadable)?;
        let refused = |what: String| ManifestError::Refused { path: path.to_owned(), what };
        if text.len() as u64 > IMAGE_MANIFEST {
            return Err(refused("it is longer than a mebibyte, the most that is accepted".to_owned()));
        }
        Manifest::parse(&text, configuration).map_err(refused)
    }

    /// The same of its text; an error in words.
    pub(crate) fn parse(text: &str, configuration: &Configuration) -> Result<Manifest, String> {
        let manifest: Manifest = serde_json::from_str(text).map_err(|error| error.to_string())?;
        manifest.check(configuration)?;
        Ok(manifest)
    }

    /// 2; 3 where there is a mirror; 4 where there is glass, at which light is bent twice.
    pub(super) fn depth_of(configuration: &Configuration) -> u32 {
        match (configuration.mirrors(), configuration.glass()) {
            (_, [_, ..]) => 4,
            ([_, ..], []) => 3,
            ([], []) => 2,
        }
    }

    /// Irradiance for each unit of radiance in a pixel: π/ρ.
    pub fn irradiance_of_radiance(&self) -> f64 {
        PI / self.rho
    }

    fn check(&self, configuration: &Configuration) -> Result<(), String> {
        let said = |what: &str, said: &dyn std::fmt::Display, due: &dyn std::fmt::Display| {
            Err(format!("{what} is {said}; accepted: {due}"))
        };
        if self.schema_version != Manifest::SCHEMA_VERSION {
            return said("schema_version", &self.schema_version, &Manifest::SCHEMA_VERSION);
        }
        let digest = configuration.digest().to_string();
        if self.digest != digest {
            return Err(format!(
                "it was written for another case (`{}`, digest {}…); this one has the digest {}…. Export it anew, or name the case that was exported",
                self.case,
                self.digest.chars().take(12).collect::<String>(),
                &digest[..12]
            ));
        }
        if !(self.rho > 0.0 && self.rho <= 1.0) {
            return said("rho", &self.rho, &"a reflectance above 0, up to 1");
        }
        if self.formula != Manifest::FORMULA {
            return said("formula", &format!("`{}`", self.formula), &format!("`{}`", Manifest::FORMULA));
        }
        if self.filter != "box" {
            return said(
                "filter",
                &format!("`{}`", self.filter),
                &"`box`: with another one a pixel records what lies beside it, and no exact value is known",
            );
        }
        let depth = Manifest::depth_of(configuration);
        if self.depth != depth {
            let why = [
                "2 (direct light)",
                "3 (direct light, and light by one mirror)",
                "4 (light through a ball of glass)",
            ];
            let why = why[(depth as usize - 2).min(2)];
            return said("depth", &self.depth, &why);
        }
        if self.samples_per_pixel == 0 {
            return said("samples_per_pixel", &0, &"1 or more");
        }
        let exitances = configuration.sources().iter().map(|source| source.exitance().watts_per_square_metre());
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
        if self.exitance.len() != exitances.len() || !self.exitance.iter().zip(exitances).all(|(a, b)| near(*a, b)) {
            return Err(format!("the exitances {:?} W/m2 are not those of the case", self.exitance));
        }
        if self.radiance.len() != self.exitance.len()
            || !self.radiance.iter().zip(&self.exitance).all(|(l, m)| near(*l, m / PI))
        {
            return Err(format!("the radiances {:?} are not the exitances over pi", self.radiance));
        }
        let grid = PixelGrid::of_receiver(configuration, [self.pixels.width, self.pixels.height]);
        match grid {
            Some(grid) if grid.agrees_with(&self.pixels) => Ok(()),
            Some(_) => Err("its pixels are not those of the case's receiver".to_owned()),
            None => Err(format!(
                "{} x {} pixels on this receiver; accepted: a rectangle, with 1 to {} pixels",
                self.pixels.width,
                self.pixels.height,
                PixelGrid::MOST_PIXELS
            )),
        }
    }
}

/// Why a manifest was refused.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ManifestError {
    #[error("{}: {source}", path.display())]
    Unreadable { path: PathBuf, source: std::io::Error },
    #[error("{}: {what}", path.display())]
    Refused { path: PathBuf, what: String },
}
