//! Rules of quadrature: adaptive Gauss–Kronrod for what must be searched, Gauss for what is known to be smooth.

use std::f64::consts::{FRAC_PI_2, PI};

/// Several integrals over one interval, taken at the same places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Integral<const N: usize> {
    pub value: [f64; N],
    /// The greater of two: the difference between the 21-point rule and its 10-point part; and the integrand's divided
    /// differences over 18 nodes, which no polynomial below degree 17 feels and which, other than the former, are never
    /// small by chance at a jump or a bend. Also what may hide between a panel's ends and its first nodes: there the
    /// integrand is held against the polynomial through all nodes.
    pub error: [f64; N],
}

struct Panel<const N: usize> {
    low: f64,
    high: f64,
    integral: Integral<N>,
}

/// What a panel's error may be.
pub(super) struct Demand<const N: usize> {
    /// The errors' sums that will do.
    pub goal: [f64; N],
    /// Panels that are not split however large their error is: noise that no panel is small enough for.
    pub floor: fn(&[f64; N]) -> [f64; N],
}

/// Adaptive quadrature: every panel whose error is above its share is halved, in rounds, until the sum will do.
///
/// Within a panel `s = middle + half sin θ`, which takes square-root ends away. Depends on nothing but its arguments.
///
/// - `breaks`: ascending; the integrand is smooth between them, or at least the user hopes so
/// - `narrowest`: panels are not halved below this width
/// - `budget`: panels after which those that remain are taken as they are, with their error estimates
/// - `demand`: from the sums so far; asked anew each round
pub(super) fn integrate<const N: usize>(
    breaks: &[f64],
    narrowest: f64,
    budget: usize,
    mut integrand: impl FnMut(f64) -> [f64; N],
    mut demand: impl FnMut(&[f64; N]) -> Demand<N>,
) -> Integral<N> {
    let mut panels: Vec<Panel<N>> =
        breaks.windows(2).map(|pair| Panel::new(pair[0], pair[1], &mut integrand)).collect();
    loop {
        let sum = total(&panels);
        let Demand { goal, floor } = demand(&sum.value);
        if panels.len() >= budget || sum.error.iter().zip(goal).all(|(error, goal)| *error <= goal) {
            return sum;
        }
        let share = 0.5 / panels.len() as f64;
        let splits = |panel: &Panel<N>| {
            let floor = floor(&panel.integral.value);
            let wants = |k: usize| panel.integral.error[k] > floor[k].max(goal[k] * share);
            panel.high - panel.low > narrowest && (0..N).any(wants)
        };
        let before = panels.len();
        let mut next = Vec::with_capacity(2 * before);
        for panel in panels {
            if splits(&panel) {
                let middle = 0.5 * (panel.low + panel.high);
                next.push(Panel::new(panel.low, middle, &mut integrand));
                next.push(Panel::new(middle, panel.high, &mut integrand));
            } else {
                next.push(panel);
            }
        }
        panels = next;
        if panels.len() == before {
            return total(&panels);
        }
    }
}

impl<const N: usize> Panel<N> {
    fn new(low: f64, high: f64, integrand: &mut impl FnMut(f64) -> [f64; N]) -> Panel<N> {
        let width = high - low;
        // From the nearer end, so that what happens close to it keeps its digits.
        let from_end = |node: f64| width * (0.5 * FRAC_PI_2 * (1.0 - node.abs())).sin().powi(2);
        let place = |node: f64| if node < 0.0 { low + from_end(node) } else { high - from_end(node) };
        let (mut at_low, mut at_high) = (integrand(place(-BRINK)), integrand(place(BRINK)));
        let (mut fine, mut coarse, mut rough) = ([0.0; N], [0.0; N], [[0.0; N]; SPANS]);
        for (i, (node, kronrod, gauss)) in KRONROD_21.into_iter().enumerate() {
            let here = integrand(place(node));
            let stretch = 0.5 * width * (FRAC_PI_2 * node).cos() * FRAC_PI_2;
            for k in 0..N {
                at_low[k] -= AT_BRINK[i] * here[k];
                at_high[k] -= AT_BRINK[20 - i] * here[k];
                let value = stretch * here[k];
                fine[k] += kronrod * value;
                coarse[k] += gauss * value;
                for (span, weights) in rough.iter_mut().zip(&DIVIDED) {
                    span[k] += weights[i] * value;
                }
            }
        }
        let unseen = from_end(KRONROD_21[0].0);
        let error = std::array::from_fn(|k| {
            let roughest = rough.iter().map(|span| span[k].abs()).fold(0.0, f64::max);
            (fine[k] - coarse[k]).abs().max(ROUGH * roughest) + unseen * (at_low[k].abs() + at_high[k].abs())
        });
        Panel { low, high, integral: Integral { value: fine, error } }
    }
}

fn total<const N: usize>(panels: &[Panel<N>]) -> Integral<N> {
    let mut sum = Integral { value: [0.0; N], error: [0.0; N] };
    for panel in panels {
        for k in 0..N {
            sum.value[k] += panel.integral.value[k];
            sum.error[k] += panel.integral.error[k];
        }
    }
    sum
}

/// ∫ over [middle − half, middle + half] by Gauss's ten points.
///
/// - error: relative to the largest value, below 1e-17 for what is analytic within four half-lengths of the middle
pub(in crate::oracle) fn gauss_10(middle: f64, half: f64, mut integrand: impl FnMut(f64) -> f64) -> f64 {
    let pair = |(x, w): (f64, f64)| w * (integrand(middle - half * x) + integrand(middle + half * x));
    half * GAUSS_10.into_iter().map(pair).sum::<f64>()
}

/// Where panels end that suit a peak of width `width` at `peak`, between two ends: geometric on both sides of it.
pub(super) fn around_a_peak(peak: f64, width: f64, low: f64, high: f64, ends: &mut Vec<f64>) {
    let reach = (high - peak).abs().max((low - peak).abs());
    let mut inside = |x: f64| {
        if x > low && x < high {
            ends.push(x);
        }
    };
    inside(peak);
    let mut step = width;
    while step < reach && step > 0.0 {
        inside(peak - step);
        inside(peak + step);
        step *= 4.0;
    }
}

/// Positive nodes and weights of Gauss's 10-point rule on [−1, 1] (Abramowitz & Stegun 1964, table 25.4).
const GAUSS_10: [(f64, f64); 5] = [
    (0.148_874_338_981_631_22, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_2, 0.269_266_719_309_996_35),
    (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
    (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
];

/// Nodes on [−1, 1] with the weights of Kronrod's 21-point rule and of the 10-point Gauss rule in it (QUADPACK, 1983).
const KRONROD_21: [(f64, f64, f64); 21] = {
    const N: [(f64, f64, f64); 11] = [
        (0.995_657_163_025_808_1, 0.011_694_638_867_371_874, 0.0),
        (0.973_906_528_517_171_7, 0.032_558_162_307_964_725, 0.066_671_344_308_688_14),
        (0.930_157_491_355_708_2, 0.054_755_896_574_351_995, 0.0),
        (0.865_063_366_688_984_5, 0.075_039_674_810_919_96, 0.149_451_349_150_580_6),
        (0.780_817_726_586_416_9, 0.093_125_454_583_697_6, 0.0),
        (0.679_409_568_299_024_4, 0.109_387_158_802_297_64, 0.219_086_362_515_982_04),
        (0.562_757_134_668_604_7, 0.123_491_976_262_065_85, 0.0),
        (0.433_395_394_129_247_2, 0.134_709_217_311_473_34, 0.269_266_719_309_996_35),
        (0.294_392_862_701_460_2, 0.142_775_938_577_060_09, 0.0),
        (0.148_874_338_981_631_22, 0.147_739_104_901_338_49, 0.295_524_224_714_752_87),
        (0.0, 0.149_445_554_002_916_9, 0.0),
    ];
    let mut rule = [(0.0, 0.0, 0.0); 21];
    let mut i = 0;
    while i < 11 {
        rule[i] = (-N[i].0, N[i].1, N[i].2);
        rule[20 - i] = N[i];
        i += 1;
    }
    rule
};

/// Weights of the divided differences over nodes j to j + 17, their magnitudes scaled to add up to one.
const DIVIDED: [[f64; 21]; SPANS] = {
    let mut table = [[0.0; 21]; SPANS];
    let mut j = 0;
    while j < SPANS {
        let mut sum = 0.0;
        let mut i = j;
        while i < j + 18 {
            let mut product = 1.0;
            let mut k = j;
            while k < j + 18 {
                if k != i {
                    product *= KRONROD_21[i].0 - KRONROD_21[k].0;
                }
                k += 1;
            }
            table[j][i] = 1.0 / product;
            sum += table[j][i].abs();
            i += 1;
        }
        i = j;
        while i < j + 18 {
            table[j][i] /= sum;
            i += 1;
        }
        j += 1;
    }
    table
};

/// The divided differences that 21 nodes allow.
const SPANS: usize = 4;
/// The rule's error over the greatest divided difference, at jumps and bends wherever they lie: at most 2.4.
const ROUGH: f64 = 3.0;

/// What the polynomial through all nodes says at `−BRINK` is this sum of its values there (Lagrange).
const AT_BRINK: [f64; 21] = {
    let mut weights = [1.0; 21];
    let mut i = 0;
    while i < 21 {
        let mut j = 0;
        while j < 21 {
            if j != i {
                weights[i] *= (-BRINK - KRONROD_21[j].0) / (KRONROD_21[i].0 - KRONROD_21[j].0);
            }
            j += 1;
        }
        i += 1;
    }
    weights
};

/// Just inside a panel's end: in s, 2.5e-12 of the panel's width.
const BRINK: f64 = 1.0 - 2e-6;

/// 1/π, where a form factor's kernel ends.
pub(super) const PER_PI: f64 = 1.0 / PI;

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn one(breaks: &[f64], f: impl Fn(f64) -> f64) -> (Integral<1>, usize) {
        let demand = |sum: &[f64; 1]| Demand { goal: [1e-13 * sum[0].abs()], floor: |_| [0.0] };
        let mut asked = 0;
        let integrand = |x| {
            asked += 1;
            [f(x)]
        };
        (integrate(breaks, 1e-15, 4000, integrand, demand), asked)
    }

    #[test]
    fn ten_points_are_exact_for_degree_19() {
        let found = gauss_10(0.5, 0.5, |x| 20.0 * x.powi(19));
        assert_relative_eq!(found, 1.0, max_relative = 2e-15);
    }

    #[test]
    fn square_root_ends_cost_nothing() {
        let (disk, asked) = one(&[-1.0, 1.0], |x| 2.0 * ((1.0 - x) * (1.0 + x)).sqrt());
        assert_relative_eq!(disk.value[0], PI, max_relative = 1e-15);
        assert!(disk.error[0] < 1e-12, "{disk:?}");
        assert_eq!(asked, 23);
    }

    /// Wherever it lies, close to the ends of panels or not.
    #[test]
    fn a_jump_is_found_to_the_last_bits() {
        for at in (0..500).map(|i| f64::from(i) / 500.0 + 3e-6 * f64::from(i % 7)) {
            let (step, asked) = one(&[0.0, 1.0], |x| f64::from(x > at));
            let off = (step.value[0] - (1.0 - at)).abs();
            assert!(step.error[0] < 1e-11 && off <= step.error[0] + 1e-15, "{at}: off by {off:e}: {step:?}");
            assert!(asked < 2500, "{at}: {asked}");
        }
    }

    #[test]
    fn a_bend_is_found_too() {
        for at in (0..20000).map(|i| f64::from(i) / 20000.0 + 1e-7 * f64::from(i % 5)) {
            let (bend, _) = one(&[0.0, 1.0], |x| (x - at).abs());
            let off = (bend.value[0] - 0.5 * (at * at + (1.0 - at) * (1.0 - at))).abs();
            assert!(bend.error[0] < 1e-12 && off <= bend.error[0] + 4e-16, "{at}: off by {off:e}: {bend:?}");
        }
    }
}
