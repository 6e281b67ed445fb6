//! The planted faults: what is wrong, where it is planted, and which verdict is to find it out.

use etendue::configuration::Configuration;
use etendue::estimator::{Estimator, for_technique};
use etendue::sampling::{Strategy, Technique};

use super::mixed::{Mixed, Weights};
use super::plain::{Plain, Slip};
use super::wrapped::{Change, Wrapped};

pub struct Fault {
    pub name: &'static str,
    pub what: &'static str,
    /// One of `rooms`.
    pub room: &'static str,
    pub strategy: Strategy,
    pub samples: &'static [u64],
    pub plant: Plant,
    /// Properties of which one is to fail.
    pub expects: &'static [&'static str],
}

#[derive(Clone, Copy)]
pub enum Plant {
    Slip(Slip),
    Change(Change),
    Mixed(Weights),
}

impl Fault {
    pub fn estimator(&self, configuration: &Configuration, technique: Technique) -> Box<dyn Estimator> {
        match self.plant {
            Plant::Slip(slip) => Box::new(Plain::new(configuration, slip)),
            Plant::Change(change) => Box::new(Wrapped { inner: for_technique(configuration, technique), change }),
            Plant::Mixed(weights) => Box::new(Mixed::new(configuration, weights)),
        }
    }
}

use Strategy::{Correlated, Random, Stratified};

const FEW: &[u64] = &[1, 4, 16];
const BIAS: &[&str] = &["bias"];
const VARIANCE: &[&str] = &["variance", "occupancy"];
const COVARIANCE: &[&str] = &["covariance"];
const NONE: &[&str] = &[];

const fn slip(
    name: &'static str,
    what: &'static str,
    room: &'static str,
    strategy: Strategy,
    slip: Slip,
    expects: &'static [&'static str],
) -> Fault {
    Fault { name, what, room, strategy, samples: FEW, plant: Plant::Slip(slip), expects }
}

const fn change(
    name: &'static str,
    what: &'static str,
    room: &'static str,
    strategy: Strategy,
    change: Change,
    expects: &'static [&'static str],
) -> Fault {
    Fault { name, what, room, strategy, samples: FEW, plant: Plant::Change(change), expects }
}

const fn mixed(name: &'static str, what: &'static str, weights: Weights) -> Fault {
    Fault { name, what, room: "disk", strategy: Random, samples: FEW, plant: Plant::Mixed(weights), expects: BIAS }
}

pub const FAULTS: &[Fault] = &[
    // What a ray brings.
    slip("no-receiver-cosine", "the cosine at the receiver dropped", "disk", Random, Slip::NoReceiverCosine, BIAS),
    slip("no-source-cosine", "the cosine at the source dropped", "disk", Random, Slip::NoSourceCosine, BIAS),
    slip(
        "source-both-sides",
        "the source shines backwards too",
        "behind the source",
        Random,
        Slip::SourceShinesBackwards,
        BIAS,
    ),
    slip(
        "receiver-both-sides",
        "light from below the horizon counts",
        "half sunk",
        Random,
        Slip::ReceiverFeelsBothSides,
        BIAS,
    ),
    slip("missing-pi", "exitance taken for radiance: no division by π", "disk", Random, Slip::NoPi, BIAS),
    slip("inverse-distance", "r instead of r²", "rectangle", Random, Slip::InverseDistance, BIAS),
    slip(
        "distance-to-centre",
        "every ray has the distance to the source's centre",
        "rectangle",
        Random,
        Slip::DistanceToCentre,
        BIAS,
    ),
    slip(
        "cosine-at-centre",
        "every ray leaves as steeply as the one from the centre",
        "rectangle",
        Random,
        Slip::CosineAtCentre,
        BIAS,
    ),
    slip(
        "measure-mix-up",
        "a density per area used as one per solid angle",
        "rectangle",
        Random,
        Slip::AreaDensityAsSolidAngle,
        BIAS,
    ),
    slip(
        "inverted-winding",
        "the source's normal points the other way",
        "triangle",
        Random,
        Slip::TurnedNormal,
        BIAS,
    ),
    slip(
        "single-precision",
        "f32 positions, 2500 km from the origin",
        "far from the origin",
        Random,
        Slip::SinglePrecision,
        BIAS,
    ),
    // Areas and maps.
    slip(
        "tessellated-area",
        "a disk's area that of its inscribed 12-gon",
        "disk",
        Random,
        Slip::TessellatedArea,
        BIAS,
    ),
    slip("half-the-sphere", "a sphere's area 2πr², sampled all over", "sphere", Random, Slip::HalfTheSphere, BIAS),
    slip("radius-u", "disk radius R u instead of R √u", "disk", Random, Slip::RadiusU, BIAS),
    slip("radius-two-root-u", "disk radius 2 R √u", "disk", Random, Slip::RadiusTwoRootU, BIAS),
    slip(
        "stretched-square",
        "square to disk by a map that does not keep areas (bright diagonals)",
        "disk",
        Random,
        Slip::StretchedSquare,
        BIAS,
    ),
    slip("crowded-poles", "sphere sampled uniformly in its polar angle", "sphere", Random, Slip::PolesCrowded, BIAS),
    slip("triangle-without-root", "triangle by u instead of √u", "triangle", Random, Slip::TriangleWithoutRoot, BIAS),
    slip(
        "coarse-numbers",
        "random numbers of three bits, rounded down",
        "rectangle",
        Random,
        Slip::CoarseNumbers,
        BIAS,
    ),
    // Textures.
    slip("half-a-texel-off", "a texture read half a texel to the side", "checker", Random, Slip::HalfATexelOff, BIAS),
    slip(
        "even-sphere-map",
        "a sphere's map read as if its rows were of equal area",
        "globe",
        Random,
        Slip::EvenSphereMap,
        BIAS,
    ),
    slip(
        "mean-exitance",
        "the mean of the texture everywhere: right power, wrong place",
        "checker",
        Random,
        Slip::MeanExitance,
        BIAS,
    ),
    // Shadow rays.
    slip("no-occluder", "occluders never asked", "penumbra", Random, Slip::NoOccluder, BIAS),
    slip(
        "starts-late",
        "shadow rays start 0.3 m away from the point",
        "contact",
        Random,
        Slip::StartsLate(0.3),
        BIAS,
    ),
    slip(
        "ends-early",
        "shadow rays end 0.3 m before the source",
        "cover near the source",
        Random,
        Slip::EndsEarly(0.3),
        BIAS,
    ),
    slip(
        "blind-beyond",
        "occluders beyond 1.5 m ignored",
        "cover near the source",
        Random,
        Slip::BlindBeyond(1.5),
        BIAS,
    ),
    slip(
        "culled-back-faces",
        "occluders stop light from one side only",
        "penumbra",
        Random,
        Slip::CullsBackFaces,
        BIAS,
    ),
    slip(
        "bounding-square",
        "a disk occluder stops what its bounding square would",
        "penumbra",
        Random,
        Slip::OccluderAsSquare,
        BIAS,
    ),
    slip(
        "lifted-point",
        "shadow rays start 5 cm above the surface",
        "contact",
        Random,
        Slip::LiftedPoint(0.05),
        BIAS,
    ),
    // Which points.
    slip("same-jitter", "one number jitters both dimensions", "rectangle", Stratified, Slip::SameJitter, BIAS),
    slip(
        "skipped-stratum",
        "the last stratum never visited, the first twice",
        "rectangle",
        Stratified,
        Slip::SkippedStratum,
        BIAS,
    ),
    slip(
        "unequal-strata",
        "strata of unequal area taken as equal",
        "rectangle",
        Stratified,
        Slip::UnequalStrata,
        BIAS,
    ),
    slip(
        "half-a-cell-off",
        "strata half a cell to the side of where they belong",
        "rectangle",
        Stratified,
        Slip::HalfACellOff,
        BIAS,
    ),
    slip("cell-centres", "no jitter: the centres of the cells", "rectangle", Stratified, Slip::CellCentres, BIAS),
    slip("half-jitter", "jitter over a quarter of the cell", "rectangle", Stratified, Slip::HalfJitter, BIAS),
    slip(
        "revisited-strata",
        "strata drawn at random, some twice and some never",
        "rectangle",
        Stratified,
        Slip::RevisitedStrata,
        VARIANCE,
    ),
    slip(
        "whole-square-jitter",
        "jitter over the whole square: not stratified at all",
        "rectangle",
        Stratified,
        Slip::WholeSquare,
        VARIANCE,
    ),
    slip(
        "one-shift",
        "one jitter for all cells passed for stratified",
        "penumbra",
        Stratified,
        Slip::OneShift,
        VARIANCE,
    ),
    slip("too-good", "stratified points passed for random ones", "rectangle", Random, Slip::GridForRandom, VARIANCE),
    slip(
        "mirrored",
        "every other point the mirror image of the one before",
        "rectangle",
        Random,
        Slip::Mirrored,
        VARIANCE,
    ),
    slip("each-twice", "every point used twice", "rectangle", Random, Slip::EachTwice, VARIANCE),
    // Streams.
    slip("same-replicate", "one stream for all replicates", "rectangle", Random, Slip::SameReplicate, BIAS),
    slip(
        "shared-by-neighbours",
        "neighbouring points have one stream",
        "rectangle",
        Random,
        Slip::SharedByNeighbours,
        COVARIANCE,
    ),
    slip(
        "not-shared",
        "shared points drawn afresh for each shading point",
        "rectangle",
        Correlated,
        Slip::NotShared,
        COVARIANCE,
    ),
    slip(
        "overlapping-replicates",
        "each replicate begins with half of the points of the one before",
        "rectangle",
        Random,
        Slip::OverlappingReplicates,
        NONE,
    ),
    // Sums.
    slip("one-too-many", "a sum of N terms divided by N + 1", "disk", Random, Slip::OneTooMany, BIAS),
    slip("divided-by-arrived", "divided by the rays that arrived", "penumbra", Random, Slip::DividedByArrived, BIAS),
    slip(
        "clamped-rays",
        "bright rays cut at a third of the brightest",
        "rectangle",
        Random,
        Slip::ClampedRays(0.2),
        BIAS,
    ),
    slip(
        "source-by-power",
        "sources chosen by their power, weighed as if evenly",
        "two sources",
        Random,
        Slip::SourceByPowerWeighedEvenly,
        BIAS,
    ),
    slip("first-source-only", "only the first source is asked", "two sources", Random, Slip::FirstSourceOnly, BIAS),
    mixed(
        "mixed-measures",
        "balance heuristic with one density in the wrong measure: weights do not sum to 1",
        Weights::MeasuresMixed,
    ),
    mixed("mixed-heuristics", "power heuristic on one side, balance on the other", Weights::HeuristicsMixed),
    // On the way out.
    change("three-per-cent", "everything 3 % too bright", "disk", Random, Change::Scaled(1.03), BIAS),
    change("three-per-cent-stratified", "everything 3 % too dark", "disk", Stratified, Change::Scaled(0.97), BIAS),
    change("three-per-cent-penumbra", "everything 3 % too dark", "penumbra", Random, Change::Scaled(0.97), BIAS),
    change(
        "three-per-cent-correlated",
        "everything 3 % too bright",
        "sphere",
        Correlated,
        Change::Scaled(1.03),
        BIAS,
    ),
    change("albedo", "radiosity in place of irradiance, albedo ½", "disk", Random, Change::Scaled(0.5), BIAS),
    change("albedo-squared", "albedo ½ applied twice", "disk", Correlated, Change::Scaled(0.25), BIAS),
    change("one-hot-point", "one lit point 30 % too bright", "penumbra", Random, Change::OnePoint(4, 1.3), BIAS),
    change(
        "one-dark-point",
        "one lit point 30 % too dark",
        "two sources",
        Correlated,
        Change::OnePoint(2, 0.7),
        BIAS,
    ),
    change(
        "moved-light",
        "light moved from the last point to the first: the mean stays",
        "disk",
        Random,
        Change::Moved(0.015),
        BIAS,
    ),
    change(
        "eight-bits",
        "stored with 8 bits of a white of 10 W/m², rounded down",
        "disk",
        Random,
        Change::EightBits(10.0),
        BIAS,
    ),
    change("clamped-estimates", "estimates cut at 0.02 W/m²", "penumbra", Random, Change::Clamped(0.02), BIAS),
    change("not-a-number", "one estimate in a thousand is no number", "disk", Random, Change::NotANumber, BIAS),
    change(
        "lost-estimates",
        "one in twenty estimates lost and not made up for",
        "disk",
        Random,
        Change::Lost(0.05),
        BIAS,
    ),
    change("blurred", "each point mixed with its neighbours (a denoiser)", "penumbra", Random, Change::Blurred, BIAS),
    change("off-by-one", "each point has its neighbour's value", "disk", Stratified, Change::OffByOne, BIAS),
    change(
        "noise-added",
        "unbiased noise on top: a quarter more variance",
        "disk",
        Random,
        Change::Noisier(1.25),
        VARIANCE,
    ),
    change(
        "noise-added-stratified",
        "unbiased noise on top: a quarter more variance",
        "rectangle",
        Stratified,
        Change::Noisier(1.25),
        VARIANCE,
    ),
    change(
        "noise-removed",
        "mixed with a second estimate: three quarters of the variance",
        "disk",
        Random,
        Change::Quieter(0.75),
        VARIANCE,
    ),
    change(
        "noise-removed-penumbra",
        "mixed with a second estimate: three quarters of the variance",
        "penumbra",
        Correlated,
        Change::Quieter(0.75),
        VARIANCE,
    ),
];
