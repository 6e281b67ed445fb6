//! Words for `etendue explain`: what a verdict means, what it does not say, and where it comes from.

use crate::case;
use crate::sampling::Strategy;

const VERDICT: &str = "\
A verdict answers one question: has a stated quantity the mean that the exact side gives it?

  pass       no evidence against it, and a deviation that matters would have been caught with 99 %
             probability: `seen from 0.34 / 10 %` means no bias above 0.34 % in the mean over the points,
             none above 10 % at the worst point that a tenth of the light reaches
  fail       the evidence against it has reached 10^6
  undecided  no evidence, and too little data to have seen such a deviation; more replicates decide

Evidence is the capital of a bettor who starts with 1 and is offered no favourable game while the
statement holds: from observations X of a mean m and a variance of at most v, with d = X - m, the product
of exp(l d - l^2 (d^2 + 2v)/6) cannot grow on average, for any l, because exp(y - y^2/6) <= 1 + y + y^2/3
(Delyon 2009). So it ever reaches 1/alpha with probability at most alpha (Ville 1939): whatever the
distribution, however few the samples, whenever one looks. alpha is 1e-6 a verdict, fixed. The capitals of
many bets, points, contrasts and sample counts are averaged: an average of such capitals is one.

The price: some 8.1 standard errors are caught where a normal test at the same level needs 7.2.

What is judged, each with v from the exact side (a pilot run where it predicts none, and the words say so):
  bias        the mean estimate is the exact irradiance, at every point, in the mean and in contrasts
  variance    squared errors have the predicted variance as their mean; smaller ones are a fault too
  covariance  the same of the mean over the points and of contrasts: errors that move together

What a pass does not say: nothing about places that were not measured; nothing below what it was `seen
from`; nothing about a bias that hides in fewer than one sample in a thousand unless the variance was
predicted (it then shows as too small a variance); nothing about speed; and nothing about the exact side
itself, whose own bound is added to the interval that m may lie in. A bias verdict leans on its variance
verdict: read them together.
";

const BIAS: &str = "\
bias: the mean estimate at every sample count is the exact irradiance.

  statement   E X = E(x) within the exact value's bound, sixteen roundings and the study's `tolerance`
  judged for  each point; the mean over the points; four cosine contrasts along the points (a bias that
              cancels in the mean is a bias); each sample count N alone, and all together (a 1/N bias hides
              in the pool, a constant one in the parts)
  variance    predicted by the exact side; else from a pilot run, two standard errors high, and capped by the
              largest contribution that one sample can make
  effect      relative deviation with its 95 % interval, of the mean; of a failure, of what failed worst
  pass        see `etendue explain verdict`; thresholds by `smallest_bias` in a case, --smallest-bias, --thorough

What it does not say: uniform sampling close to a source can miss a spike in every replicate and report a
tiny variance with a wrong mean. A predicted variance is not fooled: then the variance verdict fails.
";

const VARIANCE: &str = "\
variance: squared errors have the predicted variance as their mean.

  random, correlated   (A sum over sources of the integral of f^2 dA - F^2)/N over the visible source
  stratified           (1/N^2) sum over strata of the variance within each; beyond 2^22 strata it is bounded by
                       that of random, and not judged
  others               in the table of `etendue explain STRATEGY`

  statement   E (X - E)^2 = v within 0.1 % (the prediction's own error)
  its spread  (fourth central moment) - v^2, predicted as well
  judged for  each point and N; where points are fresh, whose estimates are independent, also all together
  pass        a deviation of 20 % of all variances alike would have been caught with 99 % probability

Both directions are faults: larger errors mean lost stratification, shared streams or a heavy tail that
should not be there; smaller ones mean points that are not what they claim.

What it does not say: a pass at `0.5 / 15 %` would have seen half a per cent if all variances were off alike,
15 % if only one sample count were. Where nothing is predicted the variance is shown, and not judged.
";

const ENERGY: &str = "\
energy: every watt that left a source is booked, once.

  books       emitted = deposited + absorbed + escaped + terminated
  checked     what the rays carried as they left is the sources' closed form; the maps hold what was deposited
  units       W; gaps relative to the sources' power
  pass        all three gaps below 10^-12, for each budget of rays: rounding, no statistics. Where theory knows what is
              deposited (exact_deposited_W), also no evidence that another share was, by the gate of `explain verdict`
  deposited   on the receiver and diffuse surfaces; absorbed by mirrors, occluders, sources, backs of diffuse
              surfaces; escaped: met nothing any more; terminated: beyond the limit of interactions ([light] depth)

What it does not say, where that column is empty: that the shares are right. Books balance as well when a lens lets
through too much; see caustic.
";

const CAUSTIC: &str = "\
caustic: rings around the axis of a caustic, or tiles of a cup's floor, get the flux that is due.

  known       one lamp, one optic on its axis, a flat receiver square to it: a beam into a paraboloid or spherical
              mirror (1 interaction), through a ball or plano-convex lens (2), a lamp over a slab (2, 4, 6, 8);
              an area source in one flat mirror (the whole receiver); a slanting beam in half of a cylinder mirror
              (1; tiles of the floor)
  exact       flux is kept along a tube of rays: the integral of Fresnel's shares over the rays that land in the ring
  statement   a group of rays brings a mean m to the ring, and never more than the flux g that it carries: its
              variance is at most m (g - m), known beforehand, and the gate of `explain verdict` applies
  pass        no evidence against it, and `seen from 0.5 / 5 %`: a deviation of 0.5 % over all rings, of 5 % in the
              worst ring that gets a hundredth of it or more, would have been caught with 99 % probability

What it does not say: nothing of other orders (reflections off the glass), of maps that are neither, of places on
the caustic itself, where the irradiance has no bound and only rings have a flux.
";

const INDIRECT: &str = "\
indirect: paths from the eye find the light that takes bends.

  estimators  eye_paths   directions with density cos/pi, weights of albedo, then roulette; sources met by chance
              next_event  every diffuse surface on the way also sends one shadow ray to each source; what is then
                          met by chance counts only behind mirrors or glass
  known       a furnace, M/(1 - albedo) everywhere, also behind glass in it; a lamp in a grey sphere, whose wall sends
              back albedo/(1 - albedo) P/(4 pi R2) everywhere alike; two disks or equal rectangles face to face, the
              radiosity equation at Gauss's nodes; an area source in one flat mirror; a bulb in a shade
  statement   each path finds the exact value in the mean, at every point and on average over the points
  variance    not predicted but bounded: the mean square S of a path obeys the equation of its mean,
              S = K[M (2B - M) + albedo S]; the gate takes any variance from above, and the verdict leans on it
  pass        `seen from 0.9 / 6 %`: as in `explain verdict`
              (of caustics ten times coarser than the case asks in the mean, five times at a point)
  length      no limit but by roulette; a path that met the guard (4096 reflections) makes the verdict undecided

What it does not say: nothing of rooms that are not in the list; they are shown in paths.csv, not judged. The
strategies measure direct light alone.

Why caustics have a map: the share of eye paths that come upon a source is in paths.csv (nought for lamps without
extent, whatever N), and variance x time of both in timings.csv (caustic_by_eye_paths, caustic_by_map).
";

const POINT_SOURCE: &str = "\
point-source: does brightness depend on distance?

A lamp of power P stands in two spheres of radii r < R. Were its \"brightness\" the same at every distance, the outer
sphere, (R/r)^2 times as large, would take (R/r)^2 times the power of the inner one: more than the lamp gives out. What
does not depend on distance is the power through either,

  4 pi r^2 x P/(4 pi r^2)  =  P  =  4 pi R^2 x P/(4 pi R^2),    ratio 1

so that irradiance falls with the square of the distance: E = I cos/d^2, I = P/(4 pi). Wherever the lamp stands in the
spheres, as long as it is in both, they fill all 4 pi of its directions.

  booked      case interreflection/two-spheres: r = 0.5 m, R = 2 m, the lamp off the middle. The inner sphere is glass of
              index 1: rays that have come through it are of order 1. caustic.csv holds what of them arrived outside
              (all), energy.csv every watt; the wrong law would need 16 times as much
  radiance    the brightness that eye and camera see, W/(m2 sr), does not fall with distance, for a source with extent:
              its image shrinks as its irradiance does. A point has no extent, and no radiance.
";

const LAMPSHADE: &str = "\
lampshade: a bulb in a shell that scatters what it lets through is a source with area.

  glow        M(n) = tau [ I (R - a.n)/d^3 + rho/(1 - rho) I/R^2 ], n the outward normal, a the bulb's place from the
              middle, d its distance from the shell there; tau let through, rho sent back inside, both diffusely
  power       P tau/(1 - rho) comes out, wherever the bulb hangs
  judged      paths from the points (`indirect`), and where the bulb is in the middle rays from the bulb, over the whole
              receiver (`caustic`, order 0)
  case        [[diffuse.sphere]] inward = true, transmittance = tau, albedo = rho, around a [[source.point]]

What it does not say: the receiver has to be black, so that no light comes back to the shell.
";

const PICTURE: &str = "\
picture: the pixels of a rendered receiver show what is due there.

  rendered    K independent pictures (32 or more): direct light by the strategy at the middle of each pixel, plus flux
              over area in the map's texel around it
  exact       direct light at that point, plus the exact mean of the bent light over that texel: one flat mirror under
              area sources, or a lamp whose caustic is known (rays are then followed for the known orders only)
  judged for  up to 144 pixels of a lattice, and their mean
  statement   as of `explain bias`: direct light with its predicted variance; a texel, of n groups of rays with a flux g
              each, with E (g/A - E/n) at most
  pass        no evidence against it, and a deviation in the mean as large as the study's `smallest_bias` would have been
              caught; what would have been seen at the worst well-lit pixel is told

Caught by it: light that is counted by the direct term and by the map, a map over the wrong area, a lost shadow.

What it does not say: nothing of the blur within a texel, of light that was scattered twice, of what a [camera] sees.
";

const COVARIANCE: &str = "\
covariance: errors of different points move together as predicted.

The mean over the points, and four cosine contrasts along them, have a variance that is made of all
covariances: sum over pairs of w_i w_j cov(i, j). With fresh points it is the sum of w_i^2 v_i; with shared points
the exact side integrates products of what one place brings to both receivers.

  statement   E (sum of w_i (X_i - E_i))^2 is the predicted value, within the prediction's own error
  pass        a deviation of 20 % would have been caught with 99 % probability

Caught by it: one random stream used by neighbouring points, a pattern that is shared though it claims to be
fresh (or the reverse), dependent replicates.

What it does not say: five combinations are not all pairs. correlation.csv shows the pairs by separation.
";

const RATE: &str = "\
rate: how variance falls with the number of samples N, as the slope of log variance over log N.

  slope      weighted least squares; weights from the spread between 32 batches of replicates
  interval   95 %, Student's t
  expected   the same fit of the predicted variances over the same N: a finite range is not the asymptote
  asymptote  -1 independent points; one point a stratum: -2 where the integrand is smooth, -3/2 where a
             shadow's edge cuts the source (Mitchell 1996); drawn beside the curve
  verdict    fail where the expected slope lies outside the interval of probability 1 - 1e-6; undecided where the
             95 % interval is wider than 0.5; shown in rates.csv, and part of no exit code: the variances
             that it is made of are judged themselves
";

const CORRELATION: &str = "\
correlation: of the errors of two points, against their distance.

  measured    mean over the pairs at one separation, of the first 512 replicates; 95 % interval by leaving out
              a sixteenth of the replicates at a time, on Fisher's scale
  predicted   0 where points are fresh; for shared points from products integrated over the source
  judged      not pair by pair; the covariance verdict does it
";

const REGION: &str = "\
region: what a point sees of the sources, decided from outlines and not from numbers.

  lit            all of every source
  penumbra       a part
  umbra          nothing, and an occluder is why
  below_horizon  nothing, because every source lies below the point's own plane or turns away
  edge           cannot be told within the bound
";

const TEXTURE: &str = "\
texture: an exitance or an albedo that varies over a surface, read from a picture, a chessboard or a polynomial.

  exitance = { checker = [8, 4], white = 2.0, black = 0.2 }
  exitance = { image = \"cross.png\", encoding = \"linear\", white = 4.0, lookup = \"bilinear\" }
  exitance = { polynomial = [e00, e10, e01, e20, e11, e02] }        on a rectangle, metres from its centre
  albedo   = { checker = [12, 11], white = 0.9, black = 0.1 }

Where a point lies on the map, (s, t) in the unit square, the lower left pixel at (0, 0):
  rectangle   along edge_u and along edge_v
  triangle    affine; `map`: \"similar\" (the default) undoes the distortion, \"half-square\" shears, or three corners
  disk        azimuth / 2 pi from `zero`, counter-clockwise seen from the lit side; (distance / radius)^2
  sphere      longitude / 2 pi eastwards from `equator`; angle from the south pole / pi, `north` up

Areas of texels are exact: sin(angle) on a sphere, what the sides leave on a triangle. Read by `texel` (the one that is
hit) or `bilinear`: then values are blended over the texels' borders in coordinates of equal area, across a sphere's seam
too, and towards the mean of its row at a pole. Either way the integral is the sum over texels of value times area; on
triangles one factor for the whole map sees to it.

Pictures are PNG, of up to 16 bits; `encoding` says whether their numbers are `linear` in light or `srgb`. Colours count by
their luminance (Rec. 709), opacity does not count.

The exact side sums texels in closed form on rectangles and triangles, and takes strips that are parted at the texels'
borders on disks and spheres, and where values are interpolated. Variances are predicted with the texture.
Derivatives (`exact --derivative`) are left empty where a textured source is seen.
";

const JUDGE: &str = "\
judge: a sampler, an estimator or a program of yours, held against the exact irradiance.

  in a Rust test   judge(&Case::shipped(\"penumbra/eclipse\")?).points(\"mine\", &sampler).assert_passes()
                   .points: a set of points in the unit square; .estimator: a whole estimator; closures will do
  any language     etendue judge CASE -- PROGRAM...
  a file           etendue verify CASE estimates.csv        etendue run CASE --points points.txt

A program reads, until its input ends,   point,x_m,y_m,z_m,nx,ny,nz,samples,replicate,seed   (a header, then a line each)
and writes, in the same order,           point,replicate,samples,value                       (W/m2; a header or none)

  point      counted from 0; x, y, z in metres; n the unit normal: the irradiance that comes straight from the sources
  samples    how many to take; what a sample is is the program's affair
  seed       of this one estimate, below 2^53: all randomness comes from it, so that estimates are independent of one
             another and the pilot's of what is judged
  answers    line by line or all at the end; any number format that has a point (0.125, 1.25e-1)

The program is told the points and no more of the room: it has its own description of it (etendue check and the case
file say what stands where). It is started twice, for a pilot and for what is judged.

What the verdict leans on. The variance of an etendue strategy is predicted; of a stranger's estimates it is not. So either
  pilot      (the default) replicates that are not judged tell it, two standard errors high; where the pilot met too few
             rays to tell, the larger of the variance of random points and M E / N stands in
  random     you state that no estimate varies more than that of as many random points (--variance random); a statement
             that is wrong makes the verdict wrong
and the verdict says which. Of a file the first quarter of the replicates is the pilot.

Points in a file (run --points FILE): one point a line, two numbers in [0, 1); an empty line between sets; as many points in
each set. A set is one replicate, at all shading points and on all sources, and none is used twice: 32 sets at least, some
thousands for a sharp verdict. `etendue points STRATEGY -n N --sets K` writes such a file.

Exit code 2, with a message, and the answers that came before kept in --out: a program that hangs (--timeout, 60 s of
silence), dies, answers out of order, twice, too little, too much, what was not asked, NaN or no number, or that gives the
pilot's estimates again with other seeds.

What a pass does not say: nothing beyond `etendue explain verdict`; and nothing of the variance, which is not judged.
";

const VERIFY: &str = "\
verify: images of another renderer, held against the exact irradiance.

  scene      etendue export CASE --for mitsuba -o DIR    scene.xml, manifest.json, render.py
  images     python DIR/render.py 64                     64 independent images, DIR/independent.npy
  verdict    etendue verify CASE DIR/independent.npy     report in --out: pixels.csv, regions.csv, verdict.json, junit.xml,
                                                         z.png, difference.png
  formats    NPY [image, row, column] (f2, f4, f8; [row, column]; a last axis of 1 or 3), PFM, OpenEXR (half, float; R G B, Y or
             one channel; each part an image; a channel named variance). Row 0 is the top one
  manifest   what the pixels are: the case's digest, the place of each on the receiver, rho; E = pi L / rho

Another renderer: `export --for json` writes the case in numbers and the same manifest. One whose first sample of a pixel always
looks at its middle says so in the manifest: \"first_sample_at_centre\": true.

Without randomness: `verify CASE estimates.csv --converging` takes estimates (point,replicate,samples,value) at three efforts or
more (column samples), and judges where they go: twice what the last changes leave is allowed for. Report: levels.csv, limits.csv.

What is judged, each by the gate of `explain verdict`:
  bias        a pixel has the exact mean over its footprint, not the value in its middle. In this order: the mean and the
              regions (lit, penumbra, umbra, edge); 15 contrasts of up to three half waves across and downwards; places: squares of
              pixels down to such as hold 48 observations (with 48 images or more, single pixels)
  neighbours  residuals of neighbouring pixels are not correlated (beyond 0.05): else a filter or a denoiser was on
  images      residuals of different images are not: else random streams were used twice. Also looked for: pixels that follow
              another pixel of the image before

  edge        pixels that a shadow's edge runs through, or nearer to them than the ray epsilon (--ray-epsilon), by which a renderer
              moves the start of its shadow rays; what moving the shadow so far changes is no fault
  umbra       no light may come: a single ray that does is a failure
  tolerance   1e-5 at least, for single precision; half-floats are refused below 1e-3 (--tolerance)
  exact       a hundredth of the images' standard error, or better: nine points where nothing changes, adaptive elsewhere

What a verdict leans on: K images differ as they do, and that spread, pooled over neighbours of the same region and taken two
standard errors high, stands in for the variance; where a neighbourhood met fewer than some thirty events, what independent
samples could have. Pixels of one image count as independent of one another; where their sums vary more than that between the
images, verdicts allow for it and say so. Of a single image, the variance that it states (a channel, or --pixel-variance); without
one there is a picture and no verdict.

A pass tells what it would have seen: `0.1 % in the mean, 6 % at the worst 2 x 2 pixels`. A failure names a likely cause only where
the image that this cause would make fits: a factor (pi, 2, 1/rho, ...), mirrored, turned, transposed, shifted by half a
pixel or one, a cosine lost, values at the middles, something added, clamped highlights, a leak into the umbra, half-floats.

Refused, with the file and what was wrong: equal images; another size than the manifest's; NaN and infinite pixels, counted, with
places; files that are cut off, foreign, or claim sizes that they do not have; the manifest of another case.

What a pass does not say: nothing below what it would have seen, nothing of other settings than those that were rendered, and
nothing of the spread itself.
";

const TOPICS: [(&str, &str, &str); 16] = [
    ("verdict", "pass, fail, undecided: what they promise", VERDICT),
    ("bias", "the mean estimate is the exact irradiance", BIAS),
    ("variance", "errors are as large as predicted", VARIANCE),
    ("covariance", "errors move together as predicted", COVARIANCE),
    ("judge", "your own sampler, estimator, program or file", JUDGE),
    ("verify", "images of another renderer", VERIFY),
    ("energy", "every watt that left a source is booked", ENERGY),
    ("caustic", "rings of a caustic get the flux that is due", CAUSTIC),
    ("indirect", "paths from the eye find what mirrors, glass and walls send on", INDIRECT),
    ("point-source", "power through two spheres: what depends on distance", POINT_SOURCE),
    ("lampshade", "a bulb in a scattering shell as a source with area", LAMPSHADE),
    ("picture", "the pixels of a rendered receiver show what is due there", PICTURE),
    ("rate", "slopes of log variance over log N", RATE),
    ("correlation", "errors of two points against their distance", CORRELATION),
    ("texture", "exitance and albedo from pictures, chessboards, polynomials", TEXTURE),
    ("region", "lit, penumbra, umbra, below_horizon, edge", REGION),
];

/// What can be explained.
pub(super) fn contents() -> String {
    let mut text = String::from("etendue explain NAME\n\n");
    for (name, what, _) in TOPICS {
        text += &format!("  {name:<18} {what}\n");
    }
    text.push('\n');
    for strategy in Strategy::ALL {
        text += &format!("  {:<18} {}\n", strategy.name(), strategy.meaning());
    }
    text + "\n  or a shipped case: etendue list names them\n"
}

/// The text on a name, or `None` where there is nothing of it.
pub(super) fn text(name: &str) -> Option<String> {
    if let Some((_, _, text)) = TOPICS.iter().find(|(topic, ..)| *topic == name) {
        return Some((*text).to_owned());
    }
    if let Some(strategy) = Strategy::from_name(name) {
        return Some(of_strategy(strategy));
    }
    let shipped = case::shipped().find(|shipped| shipped.name() == name)?;
    let comment = shipped.text().lines().take_while(|line| line.starts_with('#'));
    let comment: Vec<&str> = comment.map(|line| line.trim_start_matches('#').trim_start_matches(' ')).collect();
    Some(format!("{name}\n\n{}\n", comment.join("\n").trim_end()))
}

fn of_strategy(strategy: Strategy) -> String {
    let shared = if strategy.shares_points() {
        "one set for all shading points of a replicate"
    } else {
        "fresh for each shading point"
    };
    format!(
        "{strategy}: {}\n\n  draws      {:?}, {:?}\n  points     {shared}\n",
        strategy.meaning(),
        strategy.technique(),
        strategy.point_set()
    )
}

/// What to say of an unknown name.
pub(super) fn unknown(name: &str) -> String {
    let strategies = Strategy::ALL.into_iter().map(Strategy::name);
    let names = TOPICS.iter().map(|(topic, ..)| *topic).chain(strategies).chain(case::shipped().map(|c| c.name()));
    let near = case::nearest(name, names).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
    format!("nothing is known of `{name}`{near} (`etendue explain` lists what there is)")
}
