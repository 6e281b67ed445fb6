//! Axes: from a value to a share of the axis, with ticks that people read.

/// How values lie along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    Linear,
    /// Of values > 0.
    Log,
    /// Linear around zero up to about the given value, logarithmic beyond, both signs.
    SymmetricLog {
        linear_to: f64,
    },
}

#[derive(Clone, Debug)]
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    /// Values with their labels; an empty label is a tick without one.
    pub ticks: Vec<(f64, String)>,
    /// Labels are in units of this power of ten, which the axis' name must say: [`Axis::named`].
    power: i32,
}

impl Axis {
    /// From `low` to `high`, both ends widened to pleasant values if `round`.
    pub fn linear(low: f64, high: f64, round: bool, about: usize) -> Axis {
        let (low, high) = (within(low), within(high));
        let half = (0.5 * scale_of(low)).max(SHORTEST);
        let (low, high) = if high - low > SHORTEST { (low, high) } else { (low - half, low + half) };
        let step = pleasant_step((high - low) / about as f64);
        let (low, high) =
            if round { ((low / step).floor() * step, (high / step).ceil() * step) } else { (low, high) };
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        let values = (first..=last).map(|k| k as f64 * step);
        let power = common_power(low.abs().max(high.abs()), step);
        let ticks = values.map(|v| (v, linear_label(v, step, power))).collect();
        Axis { scale: Scale::Linear, low, high, ticks, power }
    }

    /// Powers of ten; both ends > 0. Below two decades also twos and fives, and what it takes to have two.
    pub fn log(low: f64, high: f64, about: usize) -> Axis {
        let (low, high) = (low.clamp(SHORTEST, LARGEST), high.clamp(SHORTEST, LARGEST));
        let (low, high) = if high > low { (low, high) } else { (0.5 * low, 2.0 * low) };
        let (first, last) = (low.log10(), high.log10());
        let decades = last - first;
        let every = (decades / about as f64).ceil().max(1.0) as i32;
        let shown = |v: f64| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(&v);
        let is_plain = low >= 0.5 * SMALLEST_PLAIN && high < LARGEST_PLAIN && decades < 3.0;
        let ticks = |factors: &[u32]| -> Vec<(f64, String)> {
            let is_ticked = |exponent: &i32| every <= SPARSE || exponent.rem_euclid(every) == 0;
            let exponents = (first.floor() as i32..=last.ceil() as i32).filter(is_ticked);
            let all = exponents.flat_map(|exponent| factors.iter().map(move |factor| (*factor, exponent)));
            let label = |factor: u32, exponent: i32| match factor {
                _ if is_plain => plain_label(factor, exponent),
                1 if exponent.rem_euclid(every) != 0 => String::new(),
                1 => power_label(exponent),
                _ => format!("{factor}·{}", power_label(exponent)),
            };
            let valued = all.map(|(factor, exponent)| (f64::from(factor) * 10f64.powi(exponent), factor, exponent));
            valued.filter(|(v, ..)| shown(*v)).map(|(v, factor, exponent)| (v, label(factor, exponent))).collect()
        };
        let choices: [&[u32]; 2] = [if decades < 2.0 { &[1, 2, 5] } else { &[1] }, &[1, 2, 3, 4, 5, 6, 7, 8, 9]];
        let chosen = choices.into_iter().map(ticks).find(|ticks| ticks.len() > 1);
        // Too short for that: the ticks of a linear axis.
        let (ticks, power) = chosen.map_or_else(
            || {
                let linear = Axis::linear(low, high, false, 4);
                (linear.ticks, linear.power)
            },
            |ticks| (ticks, 0),
        );
        Axis { scale: Scale::Log, low, high, ticks, power }
    }

    /// A logarithmic axis of sample counts, labelled where they are; `room` to the left and right as a factor.
    pub fn samples(counts: &[u64], room: (f64, f64), length: f64) -> Axis {
        let low = counts.iter().copied().min().unwrap_or(1).max(1) as f64 / room.0;
        let high = counts.iter().copied().max().unwrap_or(1).max(1) as f64 * room.1;
        let mut axis = Axis { scale: Scale::Log, low, high, ticks: Vec::new(), power: 0 };
        let mut free = f64::NEG_INFINITY;
        for &count in counts {
            let text = count.to_string();
            let half = 0.5 * super::text::text_width(&text, super::style::SMALL, false) + 3.0;
            let at = axis.share(count as f64) * length;
            let label = if at - half >= free { text } else { String::new() };
            if !label.is_empty() {
                free = at + half;
            }
            axis.ticks.push((count as f64, label));
        }
        axis
    }

    /// Both signs up to `largest`, linear around zero up to about `linear_to`.
    pub fn symmetric(largest: f64, linear_to: f64) -> Axis {
        let (largest, linear_to) = (within(largest), linear_to.clamp(SHORTEST, LARGEST));
        if largest < 30.0 * linear_to {
            return Axis::linear(-largest, largest, true, 6);
        }
        let decades = linear_to.log10().ceil() as i32..=largest.log10().floor() as i32;
        let every = (decades.clone().count() as f64 / 4.0).ceil().max(1.0) as i32;
        let is_plain = linear_to >= SMALLEST_PLAIN && largest < LARGEST_PLAIN;
        let mut ticks = vec![(0.0, "0".to_owned())];
        for exponent in decades.clone() {
            let power = 10f64.powi(exponent);
            let named = (decades.end() - exponent) % every == 0;
            let words = if is_plain { plain_label(1, exponent) } else { power_label(exponent) };
            let label = |sign: &str| if named { format!("{sign}{words}") } else { String::new() };
            ticks.push((power, label("+")));
            ticks.push((-power, label("−")));
        }
        Axis { scale: Scale::SymmetricLog { linear_to }, low: -largest, high: largest, ticks, power: 0 }
    }

    /// Where a value lies: 0 at the low end, 1 at the high end.
    pub fn share(&self, value: f64) -> f64 {
        let along = |v: f64| match self.scale {
            Scale::Linear => v,
            Scale::Log => v.ln(),
            Scale::SymmetricLog { linear_to } => (v / linear_to).asinh(),
        };
        let share = (along(value) - along(self.low)) / (along(self.high) - along(self.low));
        // Lines are drawn as far as they go, dash by dash, also where nobody sees them.
        share.clamp(-BEYOND, BEYOND)
    }
    pub fn low(&self) -> f64 {
        self.low
    }
    pub fn high(&self) -> f64 {
        self.high
    }
    /// A name with its unit in brackets, and in it the power of ten that the labels leave out: `E (10⁻⁴ W/m²)`.
    pub fn named(&self, name: &str) -> String {
        match (self.power, name.rfind('(')) {
            (0, _) => name.to_owned(),
            _ if name.is_empty() => String::new(),
            (_, None) => format!("{name} ({})", power_label(self.power)),
            (_, Some(at)) => format!("{}({} {}", &name[..at], power_label(self.power), &name[at + 1..]),
        }
    }
    /// A unit that stands by itself, with that power: `10⁻⁴ W/m²`.
    pub fn unit(&self, unit: &str) -> String {
        if self.power == 0 { unit.to_owned() } else { format!("{} {unit}", power_label(self.power)) }
    }
    /// The same axis without words.
    pub fn unlabelled(&self) -> Axis {
        let ticks = self.ticks.iter().map(|(v, _)| (*v, String::new())).collect();
        Axis { ticks, ..self.clone() }
    }
}

/// What is shorter is empty: a tenth of it is still a number to all its digits.
const SHORTEST: f64 = 1e-300;
/// No axis reaches further: a report may say any number that there is, and twice that is none.
const LARGEST: f64 = 1e300;

/// Decades from label to label; where there are more, those between have no ticks.
const SPARSE: i32 = 5;

/// Lengths of an axis that a value may lie beside it.
const BEYOND: f64 = 1e3;

/// A NaN is nought.
fn within(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x.clamp(-LARGEST, LARGEST) }
}

/// A length to open an empty range with.
fn scale_of(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.abs() }
}

/// 1, 2 or 5 times a power of ten, at least `rough`.
fn pleasant_step(rough: f64) -> f64 {
    let power = 10f64.powi(rough.log10().floor() as i32);
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| *s >= rough * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// The power of ten that labels up to `largest` are given in; 0 where plain numbers are short.
fn common_power(largest: f64, step: f64) -> i32 {
    let exponent = largest.log10().floor() as i32;
    if (-3..5).contains(&exponent) && decimals(step) <= 3 { 0 } else { exponent }
}

/// Digits after the point that tell multiples of a step apart.
fn decimals(step: f64) -> usize {
    (-(step.log10() + 1e-9).floor()).max(0.0) as usize
}

/// `0.25`, without a power of ten that all labels share.
fn linear_label(value: f64, step: f64, power: i32) -> String {
    if value.abs() < 1e-9 * step {
        return "0".to_owned();
    }
    let unit = 10f64.powi(power);
    format!("{:.*}", decimals(step / unit), value / unit).replace('-', "−")
}

/// What logarithmic axes label by plain numbers reaches so far.
const SMALLEST_PLAIN: f64 = 1e-3;
const LARGEST_PLAIN: f64 = 1e4;

/// `20`, `0.005`.
fn plain_label(factor: u32, exponent: i32) -> String {
    let decimals = (-exponent).max(0) as usize;
    format!("{:.decimals$}", f64::from(factor) * 10f64.powi(exponent))
}

/// `10⁻⁵`.
pub fn power_label(exponent: i32) -> String {
    match exponent {
        0 => "1".to_owned(),
        _ => format!("10{}", superscript(&exponent.to_string())),
    }
}

/// Digits and sign raised: `−3` becomes `⁻³`.
pub fn superscript(text: &str) -> String {
    let raised = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    text.chars()
        .map(|c| match c {
            '-' | '−' => '⁻',
            c => c.to_digit(10).map_or(c, |d| raised[d as usize]),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, l)| l.as_str()).filter(|l| !l.is_empty()).collect()
    }

    #[test]
    fn ticks_are_what_a_person_would_choose() {
        assert_eq!(labels(&Axis::linear(0.0, 1.5, false, 6)), ["0", "0.5", "1.0", "1.5"]);
        assert_eq!(labels(&Axis::linear(-0.03, 0.05, true, 4)), ["−0.04", "−0.02", "0", "0.02", "0.04", "0.06"]);
        assert_eq!(labels(&Axis::linear(0.0, 4e-7, true, 4)), ["0", "1", "2", "3", "4"]);
        assert_eq!(labels(&Axis::linear(-0.001, 0.001, true, 4)), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(labels(&Axis::log(2e-7, 3e-3, 6)), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³"]);
        assert_eq!(labels(&Axis::log(0.8, 30.0, 6)), ["1", "2", "5", "10", "20"]);
        assert_eq!(labels(&Axis::log(0.013, 0.18, 6)), ["0.02", "0.05", "0.1"]);
        assert_eq!(labels(&Axis::log(3e-6, 3e-5, 6)), ["5·10⁻⁶", "10⁻⁵", "2·10⁻⁵"]);
        assert_eq!(labels(&Axis::log(2.1, 4.9, 6)), ["3", "4"]);
        assert_eq!(labels(&Axis::log(2.1, 2.7, 6)), ["2.2", "2.4", "2.6"]);
        assert_eq!(labels(&Axis::samples(&[1, 4, 16, 1024], (1.2, 1.2), 300.0)), ["1", "4", "16", "1024"]);
        assert_eq!(labels(&Axis::symmetric(2e-2, 1e-4)).len(), 7);
        assert_eq!(labels(&Axis::symmetric(1.5, 0.01)), ["0", "+0.01", "−0.01", "+0.1", "−0.1", "+1", "−1"]);
    }

    #[test]
    fn what_labels_leave_out_the_name_says() {
        let small = Axis::linear(0.0, 4e-7, true, 4);
        assert_eq!(small.named("irradiance (W/m²)"), "irradiance (10⁻⁷ W/m²)");
        assert_eq!((small.named("share"), small.named("")), ("share (10⁻⁷)".to_owned(), String::new()));
        assert_eq!(Axis::linear(0.0, 4.0, true, 4).named("length (m)"), "length (m)");
    }

    #[test]
    fn an_empty_range_still_makes_an_axis() {
        for x in [0.0, 1.0, -3e-9, 5e-324, -1e-310, 1e-300, 1e300] {
            let axis = Axis::linear(x, x, true, 5);
            assert!(axis.low() < x && axis.high() > x && (2..20).contains(&axis.ticks.len()), "{axis:?}");
        }
        for (low, high) in [(0.0, 5e-324), (-1e-323, 1e-323), (1.0, 1.0 + f64::EPSILON), (-1e300, 1e300)] {
            let axis = Axis::linear(low, high, true, 5);
            assert!(axis.low() <= low && axis.high() >= high && (2..20).contains(&axis.ticks.len()), "{axis:?}");
        }
    }

    #[test]
    fn ticks_do_not_crowd_an_axis_of_many_decades() {
        for decades in [3, 12, 40, 100, 280] {
            let axis = Axis::log(1e-8, 1e-8 * 10f64.powi(decades), 12);
            assert!((4..=61).contains(&axis.ticks.len()) && (3..=13).contains(&labels(&axis).len()), "{axis:?}");
        }
    }
}
