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
}

impl Axis {
    /// From `low` to `high`, both ends widened to pleasant values if `round`.
    pub fn linear(low: f64, high: f64, round: bool, about: usize) -> Axis {
        let (low, high) =
            if high > low { (low, high) } else { (low - 0.5 * scale_of(low), low + 0.5 * scale_of(low)) };
        let step = pleasant_step((high - low) / about as f64);
        let (low, high) =
            if round { ((low / step).floor() * step, (high / step).ceil() * step) } else { (low, high) };
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        let values = (first..=last).map(|k| k as f64 * step);
        let largest = low.abs().max(high.abs());
        Axis { scale: Scale::Linear, low, high, ticks: values.map(|v| (v, linear_label(v, step, largest))).collect() }
    }

    /// Powers of ten; both ends > 0. Below two decades also twos and fives.
    pub fn log(low: f64, high: f64, about: usize) -> Axis {
        let (first, last) = (low.log10(), high.log10());
        let decades = last - first;
        let every = (decades / about as f64).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for exponent in first.floor() as i32..=last.ceil() as i32 {
            let power = 10f64.powi(exponent);
            let label = if exponent.rem_euclid(every) == 0 { power_label(exponent) } else { String::new() };
            ticks.push((power, label));
            if decades < 2.0 {
                for factor in [2, 5] {
                    ticks.push((f64::from(factor) * power, format!("{factor}·{}", power_label(exponent))));
                }
            }
        }
        ticks.retain(|(v, _)| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(v));
        Axis { scale: Scale::Log, low, high, ticks }
    }

    /// A logarithmic axis of sample counts, labelled where they are; `room` to the left and right as a factor.
    pub fn samples(counts: &[u64], room: (f64, f64), length: f64) -> Axis {
        let low = counts.iter().copied().min().unwrap_or(1).max(1) as f64 / room.0;
        let high = counts.iter().copied().max().unwrap_or(1).max(1) as f64 * room.1;
        let mut axis = Axis { scale: Scale::Log, low, high, ticks: Vec::new() };
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
        if largest < 30.0 * linear_to {
            return Axis::linear(-largest, largest, true, 6);
        }
        let decades = linear_to.log10().ceil() as i32..=largest.log10().floor() as i32;
        let every = (decades.clone().count() as f64 / 4.0).ceil().max(1.0) as i32;
        let mut ticks = vec![(0.0, "0".to_owned())];
        for exponent in decades.clone() {
            let power = 10f64.powi(exponent);
            let named = (decades.end() - exponent) % every == 0;
            let label = |sign: &str| if named { format!("{sign}{}", power_label(exponent)) } else { String::new() };
            ticks.push((power, label("+")));
            ticks.push((-power, label("−")));
        }
        Axis { scale: Scale::SymmetricLog { linear_to }, low: -largest, high: largest, ticks }
    }

    /// Where a value lies: 0 at the low end, 1 at the high end.
    pub fn share(&self, value: f64) -> f64 {
        let along = |v: f64| match self.scale {
            Scale::Linear => v,
            Scale::Log => v.ln(),
            Scale::SymmetricLog { linear_to } => (v / linear_to).asinh(),
        };
        (along(value) - along(self.low)) / (along(self.high) - along(self.low))
    }
    pub fn low(&self) -> f64 {
        self.low
    }
    pub fn high(&self) -> f64 {
        self.high
    }
    /// The same axis without words.
    pub fn unlabelled(&self) -> Axis {
        let ticks = self.ticks.iter().map(|(v, _)| (*v, String::new())).collect();
        Axis { ticks, ..self.clone() }
    }
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

/// `0.25`, or `2.5·10⁻⁷` where zeros would crowd it.
fn linear_label(value: f64, step: f64, largest: f64) -> String {
    if value.abs() < 1e-9 * step {
        return "0".to_owned();
    }
    let exponent = largest.log10().floor() as i32;
    let minus = |s: String| s.replace('-', "−");
    if (-3..5).contains(&exponent) {
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        return minus(format!("{value:.decimals$}"));
    }
    let decimals = (f64::from(exponent) - step.log10().floor()).max(0.0) as usize;
    minus(format!("{:.decimals$}·{}", value / 10f64.powi(exponent), power_label(exponent)))
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
        assert_eq!(labels(&Axis::linear(0.0, 4e-7, true, 4)), ["0", "1·10⁻⁷", "2·10⁻⁷", "3·10⁻⁷", "4·10⁻⁷"]);
        assert_eq!(labels(&Axis::log(2e-7, 3e-3, 6)), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³"]);
        assert_eq!(labels(&Axis::log(0.8, 30.0, 6)), ["1", "2·1", "5·1", "10¹", "2·10¹"]);
        assert_eq!(labels(&Axis::samples(&[1, 4, 16, 1024], (1.2, 1.2), 300.0)), ["1", "4", "16", "1024"]);
        assert_eq!(labels(&Axis::symmetric(2e-2, 1e-4)).len(), 7);
    }

    #[test]
    fn an_empty_range_still_makes_an_axis() {
        for x in [0.0, 1.0, -3e-9] {
            let axis = Axis::linear(x, x, true, 5);
            assert!(axis.low() < x && axis.high() > x && axis.ticks.len() > 1, "{axis:?}");
        }
    }
}
