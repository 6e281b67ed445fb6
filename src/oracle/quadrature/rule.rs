//! Rules of quadrature: adaptive Gauss–Kronrod for what must be searched, and where its panels end.

use std::f64::consts::PI;

/// Several integrals over one interval, taken at the same places.
#[derive(Clone, Copy, Debug)]
pub(in crate::oracle) struct Integral<const N: usize> {
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
    form: Form,
    integral: Integral<N>,
}

/// What the integrand is at the ends of an interval between breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::oracle) enum Ends {
    /// Analytic.
    Smooth,
    /// Analytic in the square root of the distance from either end.
    Roots,
}

/// How a panel is gone along: evenly, or by the square of the way from an end with a square root.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Even,
    FromLow,
    FromHigh,
}

/// What a panel's error may be.
pub(in crate::oracle) struct Demand<const N: usize> {
    /// The errors' sums that will do.
    pub goal: [f64; N],
    /// Panels that are not split however large their error is: noise that no panel is small enough for.
    pub floor: fn(&[f64; N]) -> [f64; N],
}

/// Adaptive quadrature: every panel whose error is above its share is halved, in rounds, until the sum will do.
///
/// Depends on nothing but its arguments.
///
/// - `breaks`: ascending; the integrand is analytic between them, or at least the user hopes so
/// - `narrowest`: panels are not halved below this width
/// - `budget`: panels after which those that remain are taken as they are, with their error estimates
/// - `demand`: from the sums so far; asked anew each round
pub(in crate::oracle) fn integrate<const N: usize>(
    breaks: &[f64],
    ends: Ends,
    narrowest: f64,
    budget: usize,
    mut integrand: impl FnMut(f64) -> [f64; N],
    mut demand: impl FnMut(&[f64; N]) -> Demand<N>,
) -> Integral<N> {
    let mut panels: Vec<Panel<N>> = Vec::with_capacity(4 * breaks.len());
    for pair in breaks.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        match ends {
            Ends::Smooth => panels.push(Panel::new(low, high, Form::Even, &mut integrand)),
            Ends::Roots => {
                let middle = 0.5 * (low + high);
                panels.push(Panel::new(low, middle, Form::FromLow, &mut integrand));
                panels.push(Panel::new(middle, high, Form::FromHigh, &mut integrand));
            }
        }
    }
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
                let (low, middle, high) = (panel.low, 0.5 * (panel.low + panel.high), panel.high);
                let keep = |form: Form| if panel.form == form { form } else { Form::Even };
                next.push(Panel::new(low, middle, keep(Form::FromLow), &mut integrand));
                next.push(Panel::new(middle, high, keep(Form::FromHigh), &mut integrand));
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

impl Form {
    /// Where a panel is at −1 ≤ x ≤ 1, and how fast it goes along with x there.
    fn place(self, low: f64, high: f64, x: f64) -> (f64, f64) {
        let half = 0.5 * (high - low);
        // From the nearer end, or from the root's, so that what happens close to it keeps its digits.
        match self {
            Form::Even if x < 0.0 => (low + half * (1.0 + x), half),
            Form::Even => (high - half * (1.0 - x), half),
            Form::FromLow => (low + 0.5 * half * (1.0 + x) * (1.0 + x), half * (1.0 + x)),
            Form::FromHigh => (high - 0.5 * half * (1.0 - x) * (1.0 - x), half * (1.0 - x)),
        }
    }
}

impl<const N: usize> Panel<N> {
    fn new(low: f64, high: f64, form: Form, integrand: &mut impl FnMut(f64) -> [f64; N]) -> Panel<N> {
        let place = |x: f64| form.place(low, high, x);
        let brinks = match form {
            Form::Even => [&EVEN_BRINK; 2],
            Form::FromLow => [&ROOT_BRINK, &EVEN_BRINK],
            Form::FromHigh => [&EVEN_BRINK, &ROOT_BRINK],
        };
        let mut at_low = integrand(place(-brinks[0].x).0);
        let mut at_high = integrand(place(brinks[1].x).0);
        let (mut fine, mut coarse, mut rough) = ([0.0; N], [0.0; N], [[0.0; N]; SPANS]);
        for (i, (node, kronrod, gauss)) in KRONROD_21.into_iter().enumerate() {
            let (at, stretch) = place(node);
            let here = integrand(at);
            for k in 0..N {
                at_low[k] -= brinks[0].weights[i] * here[k];
                at_high[k] -= brinks[1].weights[20 - i] * here[k];
                let value = stretch * here[k];
                fine[k] += kronrod * value;
                coarse[k] += gauss * value;
                for (span, weights) in rough.iter_mut().zip(&DIVIDED) {
                    span[k] += weights[i] * value;
                }
            }
        }
        let last = KRONROD_21[20].0;
        let unseen = [place(-last).0 - low, high - place(last).0];
        let error = std::array::from_fn(|k| {
            let roughest = rough.iter().map(|span| span[k].abs()).fold(0.0, f64::max);
            let rule = (fine[k] - coarse[k]).abs().max(ROUGH * roughest);
            rule + unseen[0] * at_low[k].abs() + unseen[1] * at_high[k].abs()
        });
        Panel { low, high, form, integral: Integral { value: fine, error } }
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

/// A place just inside a panel's end, and what the polynomial through all nodes says at the low one: a sum of its values
/// (Lagrange).
struct Brink {
    x: f64,
    weights: [f64; 21],
}

const fn brink(x: f64) -> Brink {
    let mut weights = [1.0; 21];
    let mut i = 0;
    while i < 21 {
        let mut j = 0;
        while j < 21 {
            if j != i {
                weights[i] *= (-x - KRONROD_21[j].0) / (KRONROD_21[i].0 - KRONROD_21[j].0);
            }
            j += 1;
        }
        i += 1;
    }
    Brink { x, weights }
}

/// Both are 1e-12 of the panel's width away from its end.
static EVEN_BRINK: Brink = brink(1.0 - 2e-12);
static ROOT_BRINK: Brink = brink(1.0 - 2e-6);

/// 1/π, where a form factor's kernel ends.
pub(super) const PER_PI: f64 = 1.0 / PI;

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn one(ends: Ends, breaks: &[f64], f: impl Fn(f64) -> f64) -> (Integral<1>, usize) {
        let demand = |sum: &[f64; 1]| Demand { goal: [1e-12 * sum[0].abs()], floor: |_| [0.0] };
        let mut asked = 0;
        let integrand = |x| {
            asked += 1;
            [f(x)]
        };
        (integrate(breaks, ends, 1e-15, 4000, integrand, demand), asked)
    }

    #[test]
    fn square_root_ends_cost_nothing() {
        let (disk, asked) = one(Ends::Roots, &[-1.0, 1.0], |x| 2.0 * ((1.0 - x) * (1.0 + x)).sqrt());
        assert_relative_eq!(disk.value[0], PI, max_relative = 1e-15);
        assert!(disk.error[0] < 4e-12, "{disk:?}");
        assert!(asked < 150, "{asked}");
    }

    /// Wherever it lies, close to the ends of panels or not.
    #[test]
    fn a_jump_is_found_to_the_last_bits() {
        for ends in [Ends::Smooth, Ends::Roots] {
            for at in (0..500).map(|i| f64::from(i) / 500.0 + 3e-6 * f64::from(i % 7)) {
                let (step, asked) = one(ends, &[0.0, 1.0], |x| f64::from(x > at));
                let off = (step.value[0] - (1.0 - at)).abs();
                assert!(step.error[0] < 1e-11 && off <= step.error[0] + 1e-15, "{at}: off by {off:e}: {step:?}");
                assert!(asked < 2500, "{at}: {asked}");
            }
        }
    }

    #[test]
    fn a_bend_is_found_too() {
        for ends in [Ends::Smooth, Ends::Roots] {
            for at in (0..20000).map(|i| f64::from(i) / 20000.0 + 1e-7 * f64::from(i % 5)) {
                let (bend, _) = one(ends, &[0.0, 1.0], |x| (x - at).abs());
                let off = (bend.value[0] - 0.5 * (at * at + (1.0 - at) * (1.0 - at))).abs();
                assert!(bend.error[0] < 1e-12 && off <= bend.error[0] + 4e-16, "{at}: off by {off:e}: {bend:?}");
            }
        }
    }
}
