//! One-dimensional quadrature of a function that is analytic between places where it changes its kind.
//!
//! Each node brings its kind along. Where neighbours differ, the place of change is bisected and the panel split there; next
//! to it, a substitution takes away the half-integer power with which such functions leave it. Panels that are not smooth
//! enough are halved. Deterministic; the same whatever ran before.

use std::f64::consts::FRAC_PI_2;

/// A value, what it is off by, and its kind.
#[derive(Clone, Debug)]
pub(super) struct Node<K> {
    pub value: f64,
    pub error: f64,
    pub kind: K,
}

/// An integral with the estimate of its error.
#[derive(Clone, Debug)]
pub(super) struct Integral<K> {
    pub value: f64,
    pub error: f64,
    /// The kinds met, in order, neighbours alike counted once.
    pub kinds: Vec<K>,
    /// Where the interval was split because the kind changes, in order.
    pub changes: Vec<f64>,
}

/// How good is good enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spec {
    /// Error that a panel may have, per length.
    pub density: f64,
    /// Error that any panel may have, however short.
    pub floor: f64,
    /// Width to which a change of kind is bisected, in units of the whole interval; where the function jumps there, to the
    /// last bit.
    pub resolution: f64,
    /// How far off a node may be from where it should be: what the function changes by on that way no halving takes away.
    pub blur: f64,
}

/// A node of [−1, 1] with its weights in three rules, each of which holds the nodes of the one before: 3, 7 and 15 points.
struct Nested {
    x: f64,
    fifteen: f64,
    seven: f64,
    three: f64,
    /// Legendre polynomials there: P₅, P₁₃, P₁₄.
    p5: f64,
    p13: f64,
    p14: f64,
}

const fn nested(x: f64, fifteen: f64, seven: f64, three: f64) -> Nested {
    Nested { x, fifteen, seven, three, p5: legendre(5, x), p13: legendre(13, x), p14: legendre(14, x) }
}

/// By the three-term recurrence.
const fn legendre(degree: u32, x: f64) -> f64 {
    let (mut last, mut value, mut k) = (1.0, x, 2);
    while k <= degree {
        let n = k as f64;
        (last, value) = (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * last) / n);
        k += 1;
    }
    value
}

/// Gauss, Kronrod and Patterson (Math. Comp. 22, 1968), exact to degree 5, 11 and 23; in order.
const RULES: [Nested; 15] = [
    nested(-0.993_831_963_212_755, 0.017_001_719_629_940_26, 0.0, 0.0),
    nested(-0.960_491_268_708_020_3, 0.051_603_282_997_079_74, 0.104_656_226_026_467_27, 0.0),
    nested(-0.888_459_232_872_257, 0.092_927_195_315_124_54, 0.0, 0.0),
    nested(-0.774_596_669_241_483_4, 0.134_415_255_243_784_22, 0.268_488_089_868_333_44, 0.555_555_555_555_555_6),
    nested(-0.621_102_946_737_226_4, 0.171_511_909_136_391_4, 0.0, 0.0),
    nested(-0.434_243_749_346_802_56, 0.200_628_529_376_989_02, 0.401_397_414_775_962_2, 0.0),
    nested(-0.223_386_686_428_966_9, 0.219_156_858_401_587_5, 0.0, 0.0),
    nested(0.0, 0.225_510_499_798_206_7, 0.450_916_538_658_474_14, 8.0 / 9.0),
    nested(0.223_386_686_428_966_9, 0.219_156_858_401_587_5, 0.0, 0.0),
    nested(0.434_243_749_346_802_56, 0.200_628_529_376_989_02, 0.401_397_414_775_962_2, 0.0),
    nested(0.621_102_946_737_226_4, 0.171_511_909_136_391_4, 0.0, 0.0),
    nested(0.774_596_669_241_483_4, 0.134_415_255_243_784_22, 0.268_488_089_868_333_44, 0.555_555_555_555_555_6),
    nested(0.888_459_232_872_257, 0.092_927_195_315_124_54, 0.0, 0.0),
    nested(0.960_491_268_708_020_3, 0.051_603_282_997_079_74, 0.104_656_226_026_467_27, 0.0),
    nested(0.993_831_963_212_755, 0.017_001_719_629_940_26, 0.0, 0.0),
];

/// What the polynomial through the nodes of a rule is at 1, as weights of the nodes' values.
const fn extrapolation(stride: usize) -> [f64; 15] {
    let mut weights = [0.0; 15];
    let mut i = stride - 1;
    while i < 15 {
        let mut weight = 1.0;
        let mut j = stride - 1;
        while j < 15 {
            if j != i {
                weight *= (1.0 - RULES[j].x) / (RULES[i].x - RULES[j].x);
            }
            j += stride;
        }
        weights[i] = weight;
        i += stride;
    }
    weights
}

/// For seven and for fifteen nodes.
const AT_ONE: [[f64; 15]; 2] = [extrapolation(2), extrapolation(1)];

/// How far inside the interval its ends are looked at, in units of its length: at the very ends the function may not be
/// defined.
const INSET: f64 = 1e-8;

/// Halvings before a panel is taken as it is, with its error.
const DEEPEST: u32 = 48;
/// Splits of one interval. Kinds that change more often than that flicker: they cannot be told there, and halving has to do.
const MOST_SPLITS: u32 = 24;

/// What is left of places that are off, in units of what the function changes by on the way: rules extrapolate to the ends.
const BLURRED: f64 = 8.0;

/// ∫ f over [from, to].
///
/// - `ends`: whether the function leaves that end of the interval like a half-integer power
/// - `probes`: places at which the kind is asked for besides, so that a narrow stretch of another kind is not passed over
/// - `is_spent`: once true, panels are taken as they are
pub(super) fn integrate<K: Clone + PartialEq>(
    mut f: impl FnMut(f64) -> Node<K>,
    [from, to]: [f64; 2],
    ends: [bool; 2],
    probes: &[f64],
    spec: Spec,
    is_spent: impl Fn() -> bool,
) -> Integral<K> {
    let sum = Integral { value: 0.0, error: 0.0, kinds: Vec::new(), changes: Vec::new() };
    let width = (to - from).abs();
    let within = probes.iter().filter(|t| **t > from && **t < to);
    let mut probes: Vec<(f64, Node<K>)> = within.map(|t| (*t, f(*t))).collect();
    probes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut work = Work { f, is_spent, spec, width, probes, splits: 0, sum };
    let inset = INSET * (to - from);
    let limits = [from + inset, to - inset].map(|t| (t, (work.f)(t)));
    work.panel(Panel { from, to, ends, limits, depth: 0 });
    work.sum
}

#[derive(Clone)]
struct Panel<K> {
    from: f64,
    to: f64,
    ends: [bool; 2],
    /// The function at either end, or just inside.
    limits: [(f64, Node<K>); 2],
    depth: u32,
}

impl<K: Clone + PartialEq> Panel<K> {
    /// What lies between the outermost nodes and the ends may be of another make than what the nodes see: how far the ends are
    /// from what the nodes foretell, times half the way to them.
    fn beyond_nodes(&self, nodes: &[Option<(f64, Node<K>)>; 15], is_fine: bool) -> f64 {
        let weights = &AT_ONE[usize::from(is_fine)];
        let known = || nodes.iter().enumerate().filter_map(|(i, node)| Some((i, node.as_ref()?)));
        let (Some((_, (first, low))), Some((_, (last, high)))) = (known().next(), known().last()) else { return 0.0 };
        let foretold = known().fold([0.0; 2], |[low, high], (i, (_, node))| {
            [low + weights[14 - i] * node.value, high + weights[i] * node.value]
        });
        // The end, and from there along the chord to where it was looked at.
        let off = |foretold: f64, end: f64, nearest: f64, node: &Node<K>, limit: &(f64, Node<K>)| {
            let way = end - nearest;
            ((limit.1.value - foretold) * way - (foretold - node.value) * (limit.0 - end)).abs()
        };
        let at_low = off(foretold[0], self.from, *first, low, &self.limits[0]);
        0.5 * (at_low + off(foretold[1], self.to, *last, high, &self.limits[1]))
    }

    /// Where a node of [−1, 1] lies, and what one unit there is worth here.
    fn place(&self, x: f64) -> (f64, f64) {
        let (middle, half) = (0.5 * (self.from + self.to), 0.5 * (self.to - self.from));
        match self.ends {
            [false, false] => (middle + half * x, half),
            [true, true] => {
                let (sin, cos) = (FRAC_PI_2 * x).sin_cos();
                (middle + half * sin, half * cos * FRAC_PI_2)
            }
            [true, false] => {
                let u = 0.5 * (1.0 + x);
                (self.from + 2.0 * half * u * u, 2.0 * half * u)
            }
            [false, true] => {
                let u = 0.5 * (1.0 - x);
                (self.to - 2.0 * half * u * u, 2.0 * half * u)
            }
        }
    }
}

/// How much the function goes up and down from node to node; no less than one that falls to nothing over the whole interval.
fn variation<K>(nodes: &[Option<(f64, Node<K>)>; 15], share: f64) -> f64 {
    let values = || nodes.iter().flatten().map(|(_, node)| node.value);
    let steps: f64 = values().zip(values().skip(1)).map(|(a, b)| (b - a).abs()).sum();
    steps.max(share * values().fold(0.0, |most, value| value.abs().max(most)))
}

/// Two neighbours of different kinds.
type Change<K> = ((f64, Node<K>), (f64, Node<K>));

fn differ<K: Clone + PartialEq>(low: (f64, &Node<K>), high: (f64, &Node<K>)) -> Option<Change<K>> {
    let owned = |(t, node): (f64, &Node<K>)| (t, node.clone());
    (low.1.kind != high.1.kind).then(|| (owned(low), owned(high)))
}

struct Work<K, F, S> {
    f: F,
    is_spent: S,
    spec: Spec,
    /// Of the whole interval.
    width: f64,
    probes: Vec<(f64, Node<K>)>,
    splits: u32,
    sum: Integral<K>,
}

impl<K: Clone + PartialEq, F: FnMut(f64) -> Node<K>, S: Fn() -> bool> Work<K, F, S> {
    fn panel(&mut self, panel: Panel<K>) {
        let length = panel.to - panel.from;
        let is_narrow =
            length <= 16.0 * f64::EPSILON * panel.from.abs().max(panel.to.abs()) || length <= 1e-15 * self.width;
        let is_last = is_narrow || panel.depth >= DEEPEST || (self.is_spent)();
        let enough = (self.spec.density * length).max(self.spec.floor);
        let mut nodes: [Option<(f64, Node<K>)>; 15] = std::array::from_fn(|_| None);
        let mut last_difference = f64::INFINITY;
        for is_fine in [false, true] {
            let (mut coarse, mut fine, mut own, mut size) = (0.0, 0.0, 0.0, 0.0);
            let mut wiggles = [0.0; 2];
            for (at, nested) in nodes.iter_mut().zip(&RULES) {
                let (lower, weight) =
                    if is_fine { (nested.seven, nested.fifteen) } else { (nested.three, nested.seven) };
                if weight == 0.0 {
                    continue;
                }
                let (t, stretch) = panel.place(nested.x);
                let (_, node) = at.get_or_insert_with(|| (t, (self.f)(t)));
                coarse += lower * stretch * node.value;
                fine += weight * stretch * node.value;
                wiggles[0] += weight * stretch * node.value * if is_fine { nested.p13 } else { nested.p5 };
                wiggles[1] += weight * stretch * node.value * if is_fine { nested.p14 } else { 0.0 };
                own += weight * stretch * node.error;
                size += weight * stretch * node.value.abs();
            }
            own += BLURRED * self.spec.blur * variation(&nodes, length / self.width);
            // A kink may make the two rules agree by chance, but seldom the highest Legendre terms vanish, too.
            let difference = (fine - coarse).abs().max(wiggles[0].abs()).max(wiggles[1].abs());
            let (change, passed_over) = self.changes(&nodes, &panel);
            let difference = difference + panel.beyond_nodes(&nodes, is_fine);
            // Seven points are off by less than three are. Where the differences fall fast, f is smooth and fifteen points
            // are off by (ratio)² of what seven are; where they do not, by a good part of it.
            let error = if is_fine && change.is_none() {
                difference * (20.0 * difference / last_difference).clamp(0.05, 1.0)
            } else {
                difference + passed_over
            };
            let rounding = 4.0 * f64::EPSILON * size;
            // No better than its nodes, and no worse than its share.
            if error <= enough.max(own + rounding) || (is_fine && is_last) {
                self.sum.value += fine;
                self.sum.error += error + own + rounding;
                for (_, node) in nodes.into_iter().flatten() {
                    self.meet(node.kind);
                }
                return;
            }
            if let (Some((low, high)), false, true) = (change, is_last, self.splits < MOST_SPLITS) {
                self.splits += 1;
                return self.split(panel, low, high);
            }
            last_difference = difference;
        }
        let middle = 0.5 * (panel.from + panel.to);
        let between = (middle, (self.f)(middle));
        let Panel { from, to, ends, limits: [low, high], depth } = panel;
        let depth = depth + 1;
        self.panel(Panel { from, to: middle, ends: [ends[0], false], limits: [low, between.clone()], depth });
        self.panel(Panel { from: middle, to, ends: [false, ends[1]], limits: [between, high], depth });
    }

    /// The first two neighbours, nodes, ends and probes together, that differ in kind; and what the nodes pass over: how far
    /// probes are from the line between the nodes about them, times their distance.
    fn changes(&self, nodes: &[Option<(f64, Node<K>)>; 15], panel: &Panel<K>) -> (Option<Change<K>>, f64) {
        let mut probes =
            self.probes.iter().filter(|(t, _)| *t > panel.limits[0].0 && *t < panel.limits[1].0).peekable();
        let [low, high] = &panel.limits;
        let (mut change, mut passed_over) = (None, 0.0);
        let (mut last_node, mut last) = ((low.0, &low.1), (low.0, &low.1));
        let known = nodes.iter().flatten().chain([high]).map(|(t, node)| (*t, node));
        for (t, node) in known {
            while let Some((at, probe)) = probes.next_if(|probe| probe.0 < t) {
                let share = (at - last_node.0) / (t - last_node.0);
                let line = last_node.1.value + share * (node.value - last_node.1.value);
                passed_over += (t - last_node.0) * (probe.value - line).abs();
                change = change.or_else(|| differ(last, (*at, probe)));
                last = (*at, probe);
            }
            change = change.or_else(|| differ(last, (t, node)));
            (last, last_node) = ((t, node), (t, node));
        }
        (change, passed_over)
    }

    /// Splits a panel where the kind changes between two of its nodes.
    fn split(&mut self, panel: Panel<K>, mut low: (f64, Node<K>), mut high: (f64, Node<K>)) {
        while let Some(middle) = self.halfway(&low, &high) {
            let node = (self.f)(middle);
            if node.kind == low.1.kind {
                low = (middle, node);
            } else if node.kind == high.1.kind {
                high = (middle, node);
            } else {
                // A third kind between: up to it from both sides.
                let third = (middle, node);
                low = self.last_of_its_kind(low, third.clone());
                high = self.last_of_its_kind(high, third);
                break;
            }
        }
        let Panel { from, to, ends, limits: [first, last], depth } = panel;
        let depth = depth + 1;
        let (left, right) = ([first, low.clone()], [high.clone(), last]);
        self.panel(Panel { from, to: low.0, ends: [ends[0], true], limits: left, depth });
        let gap = high.0 - low.0;
        self.sum.changes.push(0.5 * (low.0 + high.0));
        if gap > 4.0 * self.spec.resolution * self.width && !(self.is_spent)() {
            let (from, to) = (low.0, high.0);
            self.panel(Panel { from, to, ends: [true, true], limits: [low, high.clone()], depth });
        } else {
            // Half of what lies between at either end's value; it is between them but for the error that is granted.
            let (low, high) = (&low.1, &high.1);
            self.sum.value += 0.5 * gap * (low.value + high.value);
            self.sum.error += gap * ((low.value - high.value).abs() + low.error.max(high.error));
        }
        self.panel(Panel { from: right[0].0, to, ends: [true, ends[1]], limits: right, depth });
    }

    /// The last place on the way to another that is of the first one's kind.
    fn last_of_its_kind(&mut self, mut known: (f64, Node<K>), mut other: (f64, Node<K>)) -> (f64, Node<K>) {
        while let Some(middle) = self.halfway(&known, &other) {
            let node = (self.f)(middle);
            let end = if node.kind == known.1.kind { &mut known } else { &mut other };
            *end = (middle, node);
        }
        known
    }

    /// A place between two others, unless they are near enough.
    fn halfway(&self, low: &(f64, Node<K>), high: &(f64, Node<K>)) -> Option<f64> {
        let gap = (high.0 - low.0).abs();
        let is_near = gap <= self.spec.resolution * self.width;
        if is_near && gap * (high.1.value - low.1.value).abs() <= self.spec.floor || (self.is_spent)() {
            return None;
        }
        let middle = 0.5 * (low.0 + high.0);
        (middle != low.0 && middle != high.0).then_some(middle)
    }

    fn meet(&mut self, kind: K) {
        if self.sum.kinds.last() != Some(&kind) {
            self.sum.kinds.push(kind);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn spec(error: f64) -> Spec {
        Spec { density: error, floor: 1e-3 * error, resolution: 1e-9, blur: 0.0 }
    }

    #[test]
    fn the_rules_are_exact_for_their_degree() {
        for (rule, degree) in [5, 11, 23].into_iter().enumerate() {
            for power in 0..=degree {
                let exact = if power % 2 == 0 { 2.0 / f64::from(power + 1) } else { 0.0 };
                let weight = |nested: &Nested| [nested.three, nested.seven, nested.fifteen][rule];
                let sum: f64 = RULES.iter().map(|nested| weight(nested) * nested.x.powi(power)).sum();
                assert_abs_diff_eq!(sum, exact, epsilon = 4e-16);
            }
        }
    }

    /// Leaves zero like δ^{3/2} at 0.3, has a corner at 0.7 and a jump at 0.9; each told by its kind.
    fn broken(t: f64) -> Node<u8> {
        let kind = u8::from(t > 0.3) + u8::from(t > 0.7) + u8::from(t > 0.9);
        let past = |at: f64| (t - at).max(0.0);
        let value = past(0.3).powf(1.5) + past(0.7) + if t > 0.9 { 2.0 } else { 0.0 };
        Node { value, error: 0.0, kind }
    }

    #[test]
    fn changes_of_kind_are_found_and_split_at() {
        let exact = 0.7_f64.powf(2.5) / 2.5 + 0.045 + 0.2;
        for (error, most) in [(1e-6, 300), (1e-12, 800)] {
            let mut evaluations = 0;
            let f = |t: f64| {
                evaluations += 1;
                broken(t)
            };
            let found = integrate(f, [0.0, 1.0], [false, false], &[], spec(error), || false);
            assert_eq!(found.kinds, [0, 1, 2, 3]);
            let off = (found.value - exact).abs();
            assert!(off <= found.error && found.error <= 3.0 * error, "{found:?}: off {off:e}");
            assert!(evaluations < most, "{evaluations}");
        }
    }

    /// Without kinds the same function is only halved towards its kinks: dearer, and still within its own bound.
    #[test]
    fn an_untold_kink_is_bounded_too() {
        let exact = 0.7_f64.powf(2.5) / 2.5 + 0.045 + 0.2;
        let f = |t: f64| Node { kind: 0, ..broken(t) };
        let found = integrate(f, [0.0, 1.0], [false, false], &[], spec(1e-8), || false);
        let off = (found.value - exact).abs();
        assert!(off <= found.error && found.error < 1e-6, "{found:?}: off {off:e}");
    }

    #[test]
    fn a_spent_budget_ends_the_work_and_keeps_the_bound_honest() {
        let exact = 0.7_f64.powf(2.5) / 2.5 + 0.045 + 0.2;
        let count = std::cell::Cell::new(0);
        let f = |t: f64| {
            count.set(count.get() + 1);
            broken(t)
        };
        let found = integrate(f, [0.0, 1.0], [false, false], &[], spec(1e-12), || count.get() > 40);
        assert!(count.get() < 200, "{}", count.get());
        assert!((found.value - exact).abs() <= found.error && found.error > 1e-9, "{found:?}");
    }
}
