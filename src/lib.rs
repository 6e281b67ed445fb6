//! **etendue**: a radiometry verification harness.
//!
//! It holds exact irradiance for area sources behind occluders, measures how far Monte Carlo estimators are from it and
//! how noisy they are, and says so in verdicts whose error rates are known.
//!
//! The quantity, at a point x with unit normal, for Lambertian sources S of exitance M (W/m²):
//!
//! ```text
//! E(x) = Σ_S ∫_S M Vis(x, u) cosθᵢ cosθₛ / (π r²) dA        W/m², r = |u − x|
//! ```
//!
//! A room described in code, its exact irradiance, and a verdict on the estimators:
//!
//! ```
//! use etendue::configuration::{Arrangement, MeasurementPoint, Source};
//! use etendue::geometry::{DVec3, Disk, Shape};
//! use etendue::oracle::Region;
//! use etendue::radiometry::Exitance;
//! use etendue::trial::{self, Effort, Overrides, Settings};
//! use etendue::{Case, Configuration, Oracle, Verdict};
//!
//! // An eclipse: a disk source that faces down from 2 m, a smaller disk half way.
//! let disk = |height: f64, radius: f64| Disk::new(DVec3::Z * height, -DVec3::Z, radius).map(Shape::Disk);
//! let source = Source::new(disk(2.0, 0.5)?, Exitance::new(1.0))?;
//! let points = [0.0, 0.7, 1.4].map(|x| MeasurementPoint::new(DVec3::X * x, DVec3::Z).expect("finite, with a normal"));
//! let configuration =
//!     Configuration::new(vec![source], vec![disk(1.0, 0.35)?], None, points.to_vec(), Arrangement::Line)
//!         .expect("nothing in this room contradicts itself");
//!
//! // The exact side: value, bound, and how much of the source each point sees.
//! let oracle = Oracle::new(&configuration);
//! let [umbra, penumbra, lit] = points.map(|point| oracle.at(&point));
//! assert_eq!(umbra.region, Region::Umbra);
//! assert_eq!(umbra.irradiance.watts_per_square_metre(), 0.0);
//! assert_eq!(penumbra.region, Region::Penumbra);
//! assert!(penumbra.bound.watts_per_square_metre() < 1e-12);
//! assert_eq!(lit.region, Region::Lit);
//!
//! // The three strategies of the estimator, measured and judged.
//! let case = Case::new("eclipse", "An eclipse", configuration, Default::default());
//! let settings = Settings { seed: 1, effort: Effort::Quick, overrides: Overrides::default() };
//! let outcome = trial::run(&[case], &settings, &|_progress| ())?;
//! for strategy in &outcome.cases[0].strategies {
//!     assert_eq!(strategy.verdicts[0].verdict, Verdict::Pass, "{}", strategy.verdicts[0].words);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Rooms, from the ground up
//!
//! | module | its duty |
//! |---|---|
//! | [`geometry`] | shapes and frames, no light in them yet |
//! | [`texture`] | what varies over a surface: maps, values on texels, lookups that lose nothing |
//! | [`statistics`] | moments, intervals, evidence, verdicts; knows nothing of light |
//! | [`radiometry`] | quantities and the products that are laws between them |
//! | [`configuration`] | what stands in the room, valid by construction |
//! | [`oracle`] | **truth**: exact irradiance with a bound on its error |
//! | [`sampling`], [`scene`], [`estimator`] | **measurement**: streams and strategies, what blocks a ray, the estimator |
//! | [`light`] | rays from the light: caustic maps, and the ledger of every watt |
//! | [`path`] | paths from the eye: light that goes to and fro between diffuse surfaces |
//! | [`eye`] | pictures: what a camera sees, shaded by the estimators and the caustic maps |
//! | [`external`] | other renderers: a case as a scene of theirs, their images read |
//! | [`case`] | case files; the shipped cases |
//! | [`trial`] | a run: pilot, plan, measurement, judgement, where truth and measurement meet |
//! | [`guest`] | others, judged: a sampler or estimator in code, a program behind a pipe, files of estimates and points |
//! | [`calibration`] | the gate itself, measured: false alarms, coverage, power |
//! | [`report`] | tables and plots of a run |
//!
//! Truth and measurement share shapes and configurations and nothing else.
//!
//! # Features
//!
//! | feature | what it brings |
//! |---|---|
//! | `cli` (default) | the program; takes `studies` |
//! | `plots` (default) | variance curves, profiles and pictures as SVG, PNG and EXR; takes `studies` |
//! | `studies` | everything else: `trial::run` and its tables, other techniques, rays from the light, eye paths, pictures, other renderers, programs and files of estimates, patches, limits, derivatives, PNG textures; takes `fast` |
//! | `fast` | rayon's threads (else those of the standard library), obvhs's hierarchies over meshes (else halved ones): the same numbers, sooner |
//!
//! Without any it is the slim build, for who judges a sampler or an estimator in `cargo test`
//! (`etendue = { version = "0.1", default-features = false }`): [`judge`], cases in code and from files, the exact side at a
//! point, predicted variances. A camera of a case is read there and not asked whether it stands free; a picture as a texture
//! is an error that names the feature. Intervals of variances and correlations, which no verdict rests on, agree to 1e-8.
//!
//! # Limits
//!
//! Mirrors, glass, lamps without area and further diffuse surfaces are followed by rays from the light ([`light`]); the
//! estimators and the exact side see them as what blocks direct light.
//!
//! Direct light of Lambertian sources (disk, rectangle, polygon, sphere) on points of any pose, behind opaque occluders (the
//! same shapes and meshes). Estimators are judged on uniform sources; the exact side also takes an exitance that varies
//! over the source (`ExitancePolynomial` in closed form, any function by `Oracle::by_quadrature_with`).
//!
//! The exact side takes a mesh that is not flat as one occluder, bounded by its silhouette as the point sees it: all edges
//! are looked at for each point, and only those of the silhouette are crossed with the other outlines. A flat mesh is the
//! outline of its merged faces. Where an occluder may cut into a sphere source the value comes from quadrature and says so;
//! where outlines touch within rounding, what is in doubt counts in the bound.
//!
//! Also on the exact side, each within its own limits: where umbra and penumbra begin and end along a line
//! ([`oracle::limits`]; `etendue exact --limits`), derivatives with respect to the numbers of a case
//! ([`Oracle::derivatives`]; `etendue exact --derivative`), form factors between patches ([`oracle::patch`]), light by way
//! of mirrors and glass ([`oracle::optics`]), and a second witness that shares no contour code with the first ([`Oracle::by_quadrature`]).
//!
//! Variances are predicted ([`oracle::variance`]) for all techniques and for independent and stratified points. For other
//! point sets those of a pilot run of its own streams plan and judge, taken on the high side.
#![forbid(unsafe_code)]
// What smaller builds leave out has left helpers here and there. The build with all features tells what nobody uses.
#![cfg_attr(not(feature = "plots"), allow(dead_code))]

#[cfg(feature = "studies")]
pub mod calibration;
pub mod case;
#[cfg(feature = "cli")]
pub mod cli;
pub mod configuration;
mod errors;
pub mod estimator;
#[cfg(feature = "studies")]
pub mod external;
pub mod eye;
#[cfg(any(fuzzing, all(test, feature = "plots")))]
#[doc(hidden)]
pub mod fuzzing;
pub mod geometry;
pub mod guest;
pub mod intake;
#[cfg(feature = "studies")]
pub mod journal;
pub mod light;
mod number;
pub mod oracle;
#[cfg(feature = "studies")]
pub mod path;
pub mod radiometry;
#[cfg(feature = "studies")]
pub mod report;
pub mod sampling;
pub mod scene;
pub mod statistics;
pub mod texture;
mod threads;
pub mod trial;

pub use case::Case;
pub use configuration::Configuration;
#[cfg(feature = "studies")]
pub use estimator::AreaEstimator;
pub use estimator::{IrradianceEstimator, PointSampler};
pub use guest::judge;
pub use oracle::{Oracle, Truth};
pub use sampling::{Draws, Strategy};
pub use statistics::Verdict;
pub use trial::{RunOutcome, Settings};

/// The README's code is tested as the documentation is.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
