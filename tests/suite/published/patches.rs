//! The rows of `patches.csv`, and the ways to each.
//!
//! One way is always the mean of the exact point value over the first patch, by Gauss's rule between the curves along which
//! the shadow's edge meets an edge or a corner of the second patch. The other is what symmetry leaves of the integral over
//! both patches. A third, the crate's own `patch_to_patch`, which knows no symmetry, has to agree within its bound.

use std::f64::consts::{FRAC_PI_2, PI};

use etendue::Oracle;
use etendue::configuration::MeasurementPoint;
use etendue::geometry::DVec3;
use etendue::oracle::patch::{
    Patch, Tolerance, disk_to_disk, patch_to_patch, rectangle_to_adjoining_rectangle, rectangle_to_opposite_rectangle,
};

use super::geometry::{Thing, occluders, room, the, things};
use super::{Pair, Row};
use crate::gauss::{Gauss, graded, panels};

const DISKS: [(&str, &str); 4] = [
    (
        "disk-to-disk-past-disk-even",
        "from disk center 0 0 0 normal 0 0 1 radius 1; to disk center 0 0 1 normal 0 0 -1 radius 1; \
         occluder disk center 0 0 0.5 normal 0 0 1 radius 0.5",
    ),
    (
        "disk-to-disk-past-disk-small",
        "from disk center 0 0 0 normal 0 0 1 radius 0.5; to disk center 0 0 2 normal 0 0 -1 radius 1; \
         occluder disk center 0 0 0.5 normal 0 0 1 radius 0.25",
    ),
    (
        "disk-to-disk-past-disk-eclipse",
        "from disk center 0 0 0 normal 0 0 1 radius 1; to disk center 0 0 2 normal 0 0 -1 radius 0.5; \
         occluder disk center 0 0 1 normal 0 0 1 radius 0.375",
    ),
    (
        "disk-to-disk-past-disk-nearly-shut",
        "from disk center 0 0 0 normal 0 0 1 radius 0.5; to disk center 0 0 1 normal 0 0 -1 radius 0.5; \
         occluder disk center 0 0 0.5 normal 0 0 1 radius 0.46875",
    ),
];

const SQUARES: [(&str, &str); 4] = [
    (
        "square-to-square-past-square-even",
        "from rectangle center 0 0 0 edge_u 1 0 0 edge_v 0 1 0; to rectangle center 0 0 1 edge_u 0 1 0 edge_v 1 0 0; \
         occluder rectangle center 0 0 0.5 edge_u 0.5 0 0 edge_v 0 0.5 0",
    ),
    (
        "square-to-square-past-square-near",
        "from rectangle center 0 0 0 edge_u 1 0 0 edge_v 0 1 0; to rectangle center 0 0 1 edge_u 0 1 0 edge_v 1 0 0; \
         occluder rectangle center 0 0 0.25 edge_u 0.5 0 0 edge_v 0 0.5 0",
    ),
    (
        "square-to-square-past-square-uneven",
        "from rectangle center 0 0 0 edge_u 2 0 0 edge_v 0 2 0; to rectangle center 0 0 2 edge_u 0 1 0 edge_v 1 0 0; \
         occluder rectangle center 0 0 1.5 edge_u 0.75 0 0 edge_v 0 0.75 0",
    ),
    (
        "square-to-square-past-square-nearly-shut",
        "from rectangle center 0 0 0 edge_u 1 0 0 edge_v 0 1 0; to rectangle center 0 0 1 edge_u 0 1 0 edge_v 1 0 0; \
         occluder rectangle center 0 0 0.5 edge_u 0.9375 0 0 edge_v 0 0.9375 0",
    ),
];

const SQUARES_PAST_DISK: [(&str, &str); 3] = [
    (
        "square-to-square-past-disk-small",
        "from rectangle center 0 0 0 edge_u 1 0 0 edge_v 0 1 0; to rectangle center 0 0 1 edge_u 0 1 0 edge_v 1 0 0; \
         occluder disk center 0 0 0.5 normal 0 0 1 radius 0.125",
    ),
    (
        "square-to-square-past-disk-large",
        "from rectangle center 0 0 0 edge_u 1 0 0 edge_v 0 1 0; to rectangle center 0 0 1 edge_u 0 1 0 edge_v 1 0 0; \
         occluder disk center 0 0 0.5 normal 0 0 1 radius 0.25",
    ),
    (
        "square-to-square-past-disk-far",
        "from rectangle center 0 0 0 edge_u 1 0 0 edge_v 0 1 0; to rectangle center 0 0 3 edge_u 0 1 0 edge_v 1 0 0; \
         occluder disk center 0 0 1.5 normal 0 0 1 radius 0.1875",
    ),
];

/// 3 m high; floor plan: the square 3 × 3 less its corner [1, 3] × [1, 3].
const L_ROOM: (&str, &str) = (
    "l-room-outer-wall-to-outer-wall",
    "from rectangle center 0 1.5 1.5 edge_u 0 3 0 edge_v 0 0 3; to rectangle center 1.5 0 1.5 edge_u 0 0 3 edge_v 3 0 0; \
     occluder rectangle center 2 1 1.5 edge_u 2 0 0 edge_v 0 0 3; occluder rectangle center 1 2 1.5 edge_u 0 2 0 edge_v 0 0 3",
);

/// Nodes of a panel.
const NODES: u32 = 24;

/// Every row, found both ways.
pub fn rows() -> Vec<Row> {
    let disks = DISKS.map(|row| found(row, "contour over from; strips over to, turned around", coaxial_disks));
    let squares = SQUARES.map(|row| found(row, "contour over from; product of widths", aligned_squares));
    let past_disk = SQUARES_PAST_DISK.map(|row| found(row, "contour over from; common area", squares_past_disk));
    let room = found(L_ROOM, "contour over from; one integral", l_room);
    disks.into_iter().chain(squares).chain(past_disk).chain([room]).collect()
}

/// - `ways`: finds the factors without and with the occluders, both twice
fn found((id, geometry): (&str, &str), words: &str, ways: impl Fn(&[Thing]) -> [Pair; 2]) -> Row {
    let all = things(geometry);
    let [unobstructed, obstructed] = ways(&all);
    let (from, to) = (the(&all, "from").patch(), the(&all, "to").patch());
    let third = patch_to_patch(&from, &to, &occluders(&all), Tolerance::relative(1e-5)).expect("a pair of patches");
    let apart = (third.form_factor.ratio() - obstructed.0[0]).abs();
    assert!(apart <= third.bound, "{id}: {third:?} is {apart:e} from {obstructed:?}");
    Row {
        id: id.to_owned(),
        view: None,
        geometry: geometry.to_owned(),
        unobstructed,
        obstructed,
        ways: words.to_owned(),
    }
}

/// How a point of one patch sees another, without and with what stands between.
struct Sight {
    normal: DVec3,
    oracles: [Oracle; 2],
}

impl Sight {
    fn new(from: &Patch, to: &Patch, occluders: Vec<etendue::geometry::Shape>) -> Sight {
        let elsewhere = MeasurementPoint::new(DVec3::splat(100.0), DVec3::Z).expect("a point");
        let oracle = |occluders| Oracle::new(&room(to.shape(), occluders, elsewhere));
        Sight { normal: from.normal(), oracles: [oracle(Vec::new()), oracle(occluders)] }
    }
    fn of(things: &[Thing]) -> Sight {
        Sight::new(&the(things, "from").patch(), &the(things, "to").patch(), occluders(things))
    }
    fn point(&self, at: DVec3) -> MeasurementPoint {
        MeasurementPoint::new(at, self.normal).expect("a point")
    }
    fn contour(&self, which: usize, at: DVec3) -> f64 {
        self.oracles[which].at(&self.point(at)).form_factor.ratio()
    }
    fn strips(&self, which: usize, at: DVec3) -> f64 {
        self.oracles[which].by_quadrature(&self.point(at)).form_factor.ratio()
    }
}

/// Coaxial disks, radii r₁ (at z = 0), b (at z), r₂ (at h). F(ρ) depends on the distance from the axis alone:
///
/// ```text
/// F₁₂ = (2/r₁²) ∫₀^{r₁} F(ρ) ρ dρ
/// ```
///
/// First way: this, F by contour. Second: the same from the other disk, F by strips, and r₁² F₁₂ = r₂² F₂₁. On the plane of
/// the disk looked at, the shadow's radius is S = b h/z and its centre k ρ off the axis, k = (h − z)/z; its rim touches the
/// disk's where k ρ = |S − r₂| and k ρ = S + r₂.
fn coaxial_disks(all: &[Thing]) -> [Pair; 2] {
    let [from, to, between] = ["from", "to", "occluder"].map(|role| the(all, role));
    let gauss = Gauss::new(NODES);
    let height = to.vector("center").z;
    let mean = |radius: f64, other: f64, to_occluder: f64, f: &dyn Fn(f64) -> f64| {
        let shadow = between.number("radius") * height / to_occluder;
        let per = to_occluder / (height - to_occluder);
        let touching = [(shadow - other).abs() * per, (shadow + other) * per];
        let places = panels(0.0, radius, &touching, 0.25 * height);
        let ring = |rho: f64| rho * f(rho);
        let sum: f64 = places.windows(2).map(|pair| gauss.over_with_roots([pair[0], pair[1]], ring)).sum();
        2.0 * sum / (radius * radius)
    };
    let [r1, r2] = [from, to].map(|disk| disk.number("radius"));
    let z = between.vector("center").z;
    let there = Sight::of(all);
    let back = Sight::new(&to.patch(), &from.patch(), occluders(all));
    let first = |which| mean(r1, r2, z, &|rho| there.contour(which, DVec3::new(rho, 0.0, 0.0)));
    let turned = r2 * r2 / (r1 * r1);
    let second = turned * mean(r2, r1, height - z, &|rho| back.strips(1, DVec3::new(rho, 0.0, height)));
    let closed = disk_to_disk(r1, r2, height).expect("disks").ratio();
    [Pair([closed, first(0)]), Pair([first(1), second])]
}

/// Aligned parallel squares of half edges a (at z = 0), b (at z = t h), c (at h).
///
/// Whether a ray from (x, y) to (x + X, y + Y) passes the plate is a matter of x and X, and of y and Y, apart from each
/// other. So what the plate takes is
///
/// ```text
/// F_taken = 1/(4a²) ∬ w(X) w(Y) h²/(π (X² + Y² + h²)²) dX dY
/// w(X) = length of { x : |x| ≤ a, |x + X| ≤ c, |x + t X| ≤ b }
/// ```
///
/// with w linear between its kinks, which is the second way (the same without the plate: the third condition falls away).
/// First way: on the upper plane the shadow's edges lie at (σ b − (1 − t) x)/t, σ = ±1; they meet the square's where that is
/// ±c.
fn aligned_squares(all: &[Thing]) -> [Pair; 2] {
    let [from, to, between] = ["from", "to", "occluder"].map(|role| the(all, role));
    let half = |square: &Thing| 0.5 * square.vector("edge_u").length();
    let [a, b, c] = [from, between, to].map(half);
    let h = to.vector("center").z;
    let t = between.vector("center").z / h;
    let gauss = Gauss::new(NODES);

    let meeting: Vec<f64> = [1.0, -1.0].map(|sign| ((b + sign * c * t) / (1.0 - t)).abs()).to_vec();
    let places = panels(0.0, a, &meeting, 0.5 * h);
    let sight = Sight::of(all);
    let row = |which, x| gauss.between(&places, |y| sight.contour(which, DVec3::new(x, y, 0.0)));
    let first = |which| gauss.between(&places, |x| row(which, x)) / (a * a);

    let kernel = |x: f64, y: f64| h * h / (PI * (x * x + y * y + h * h).powi(2));
    let kinks = [(c - a).abs(), (b - a).abs() / t, (c - b).abs() / (1.0 - t), (a + b) / t, (c + b) / (1.0 - t)];
    let places = panels(0.0, a + c, &kinks, 0.5 * h);
    let taken = |plate: f64| {
        let w = |x: f64| {
            let (low, high) = (-a.min(c + x).min(plate + t * x), a.min(c - x).min(plate - t * x));
            (high - low).max(0.0)
        };
        let row = |x: f64| w(x) * gauss.between(&places, |y| w(y) * kernel(x, y));
        gauss.between(&places, row) / (a * a)
    };
    let whole = taken(f64::INFINITY);
    let closed =
        if a == c { rectangle_to_opposite_rectangle(2.0 * a, 2.0 * a, h).expect("squares").ratio() } else { whole };
    [Pair([closed, first(0)]), Pair([first(1), whole - taken(b)])]
}

/// Equal squares of half edge a at z = 0 and h, a disk of radius b ≤ a/2 at h/2.
///
/// Rays of the difference (X, Y) that pass the disk start on an area W: that of a disk of radius b in a rectangle of half
/// edges u = a − |X|/2, v = a − |Y|/2 about the same centre. Second way:
///
/// ```text
/// F_taken = 1/(4a²) ∬ W h²/(π (X² + Y² + h²)²) dX dY = (16/a²) ∫₀ᵃ∫₀ᵃ ¼W(u, v) h²/(π (4(a−u)² + 4(a−v)² + h²)²) du dv
/// ```
///
/// First way: seen from (a − u, a − v), the shadow on the upper square has the radius 2b, touches its edges at u = 2b and
/// v = 2b, and passes its corner at u² + v² = (2b)².
fn squares_past_disk(all: &[Thing]) -> [Pair; 2] {
    let [from, to, between] = ["from", "to", "occluder"].map(|role| the(all, role));
    let a = 0.5 * from.vector("edge_u").length();
    let (b, h) = (between.number("radius"), to.vector("center").z);
    assert!(2.0 * b <= a && between.vector("center").z == 0.5 * h && to.vector("edge_v").length() == 2.0 * a);
    let sight = Sight::of(all);
    let first = |which| over_corner(a, 2.0 * b, |u, v| sight.contour(which, DVec3::new(a - u, a - v, 0.0))) / (a * a);
    let segment = |s: f64| 0.5 * (s * ((b - s) * (b + s)).sqrt() + b * b * (s / b).asin());
    let quarter = 0.25 * PI * b * b;
    let common = |u: f64, v: f64| match (u >= b, v >= b) {
        (true, true) => quarter,
        (true, false) => segment(v),
        (false, true) => segment(u),
        (false, false) if u * u + v * v <= b * b => u * v,
        (false, false) => segment(u) + segment(v) - quarter,
    };
    let kernel = |u: f64, v: f64| {
        let (x, y) = (2.0 * (a - u), 2.0 * (a - v));
        h * h / (PI * (x * x + y * y + h * h).powi(2))
    };
    let taken = 16.0 * over_corner(a, b, |u, v| common(u, v) * kernel(u, v)) / (a * a);
    let closed = rectangle_to_opposite_rectangle(2.0 * a, 2.0 * a, h).expect("squares").ratio();
    [Pair([closed, first(0)]), Pair([first(1), closed - taken])]
}

/// ∫₀ᵃ∫₀ᵃ f du dv, where f changes its make at u = r, v = r and on the quarter circle u² + v² = r² between them.
///
/// Inside, u = r sin θ and v = r sin φ: f is analytic in the angles on both sides of θ + φ = π/2.
fn over_corner(a: f64, r: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    let gauss = Gauss::new(32);
    let beyond = panels(r, a, &[], 0.25 * a);
    let column = |u: f64, theta: f64| {
        let angles = [0.0, FRAC_PI_2 - theta, FRAC_PI_2];
        let within = gauss.between(&angles, |phi| r * phi.cos() * f(u, r * phi.sin()));
        within + gauss.between(&beyond, |v| f(u, v))
    };
    let within = gauss.between(&[0.0, FRAC_PI_2], |theta| r * theta.cos() * column(r * theta.sin(), theta));
    within + gauss.between(&beyond, |u| column(u, 0.5 * FRAC_PI_2))
}

/// The L-shaped room. On the wall x = 0 the place (0, y) sees the wall y = 0 up to x = X(y): 3 for y ≤ 3/2, else y/(y − 1).
///
/// Second way: the integrals over both heights and over x have closed forms, which leaves, with h = 3,
///
/// ```text
/// 9 π F = ∫₀³ y h [G(√(X² + y²)) − G(y)] dy,   G(ρ) = ln(1 + h²/ρ²)/(2h) − atan(h/ρ)/ρ
/// ```
///
/// First way: the point value over the wall, with panels that shrink towards the common edge and its ends, where it has no
/// series.
fn l_room(all: &[Thing]) -> [Pair; 2] {
    let gauss = Gauss::new(NODES);
    let sight = Sight::of(all);
    let places: Vec<f64> = graded(1.5, 1e-12).into_iter().chain([2.25, 3.0]).collect();
    let column = |which: usize, y: f64, low: f64| {
        // The upper half sees what the lower does; nearer than the strip is wide there is nothing to resolve.
        let heights = graded(1.5, low);
        2.0 * gauss.between(&heights, |z| sight.contour(which, DVec3::new(0.0, y, z)))
    };
    let first = |which| {
        let strips = places[1..].windows(2).map(|pair| gauss.over([pair[0], pair[1]], |y| column(which, y, pair[0])));
        // Nearer to the edge than 1e-12 the other wall fills half of what is seen, but for as small a part.
        (strips.sum::<f64>() + 0.5 * 3.0 * places[1]) / 9.0
    };
    let g = |rho: f64| (9.0 / (rho * rho)).ln_1p() / 6.0 - (3.0 / rho).atan() / rho;
    let one =
        |reach: &dyn Fn(f64) -> f64| gauss.between(&places, |y| 3.0 * y * (g(reach(y).hypot(y)) - g(y))) / (9.0 * PI);
    let past_edge = one(&|y| if y <= 1.5 { 3.0 } else { y / (y - 1.0) });
    let closed = rectangle_to_adjoining_rectangle(3.0, 3.0, 3.0).expect("walls").ratio();
    [Pair([closed, first(0)]), Pair([first(1), past_edge])]
}
