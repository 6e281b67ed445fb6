//! Real roots of a trigonometric polynomial of degree two: where two cones over circles meet.

use std::f64::consts::TAU;

use crate::number::Number;

/// `a0 + a1 cos t + b1 sin t + a2 cos 2t + b2 sin 2t`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trigonometric {
    pub a0: f64,
    pub a1: f64,
    pub b1: f64,
    pub a2: f64,
    pub b2: f64,
}

/// At most four, in no particular order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Roots {
    values: [f64; 4],
    count: usize,
}

impl Roots {
    pub fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }
    fn push(&mut self, t: f64) {
        // Cells share their ends; a root there may be found from both sides.
        let again = self.as_slice().iter().any(|s| (s - t).abs() < 1e-15);
        if !again && self.count < 4 {
            self.values[self.count] = t;
            self.count += 1;
        }
    }
}

/// The first cells: eight of them, 2π/8 wide.
const FIRST_CELLS: usize = 8;
/// Below this width a cell in which f, f′ and f″ all vanish holds a triple root: its middle stands for all three.
const NARROWEST: f64 = 1e-6;

impl Trigonometric {
    /// The square of `x[0] + x[1] cos t + x[2] sin t`, times `sign`, added to `self`.
    pub fn add_square(&mut self, x: [f64; 3], sign: f64) {
        self.a0 += sign * (x[0] * x[0] + 0.5 * (x[1] * x[1] + x[2] * x[2]));
        self.a1 += sign * 2.0 * x[0] * x[1];
        self.b1 += sign * 2.0 * x[0] * x[2];
        self.a2 += sign * 0.5 * (x[1] - x[2]) * (x[1] + x[2]);
        self.b2 += sign * x[1] * x[2];
    }

    pub const ZERO: Trigonometric = Trigonometric { a0: 0.0, a1: 0.0, b1: 0.0, a2: 0.0, b2: 0.0 };

    /// f, f′, f″ at t.
    fn jet(&self, t: f64) -> [f64; 3] {
        let (s, c) = sin_cos(t);
        let (s2, c2) = (2.0 * s * c, (c - s) * (c + s));
        let (first, first_slope) = (self.a1 * c + self.b1 * s, self.b1 * c - self.a1 * s);
        let (second, second_slope) = (self.a2 * c2 + self.b2 * s2, self.b2 * c2 - self.a2 * s2);
        [self.a0 + first + second, first_slope + 2.0 * second_slope, -first - 4.0 * second]
    }

    /// All sign changes of f over one turn. A cell is halved until f has no root in it, or is monotone, or f′ is
    /// (then f is monotone on both sides of the one extremum): no root is missed, however the roots crowd, except a
    /// pair whose extremum lies within the rounding of f.
    pub fn roots(&self) -> Roots {
        let first = Number::hypot(self.a1, self.b1);
        let second = Number::hypot(self.a2, self.b2);
        let mut roots = Roots::default();
        if self.a0.abs() > first + second {
            return roots;
        }
        let curvature = first + 4.0 * second;
        let jerk = first + 8.0 * second;
        let noise = 8.0 * f64::EPSILON * (self.a0.abs() + first + second);
        // Neighbouring cells share their ends to the last bit, and so the sign of f there.
        let mut stack = [(0.0, 0.0); 64];
        let mut depth = FIRST_CELLS;
        for (i, cell) in stack.iter_mut().enumerate().take(FIRST_CELLS) {
            let end = |i: usize| TAU * (i as f64 / FIRST_CELLS as f64);
            *cell = (end(i), end(i + 1));
        }
        while depth > 0 {
            depth -= 1;
            let (low, high) = stack[depth];
            let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
            let [f, slope, bend] = self.jet(middle);
            let rest = jerk * half * half * half / 6.0;
            if f.abs() > slope.abs() * half + 0.5 * bend.abs() * half * half + rest + noise {
                continue;
            }
            if slope.abs() > (bend.abs() * half + 0.5 * jerk * half * half).min(curvature * half) {
                self.monotone(low, high, Some((middle, [f, slope])), curvature, &mut roots);
            } else if bend.abs() > jerk * half {
                match bracketed(low, high, Some((middle, [slope, bend])), jerk, |t| self.slopes(t)) {
                    Some(top) => {
                        self.monotone(low, top, None, curvature, &mut roots);
                        self.monotone(top, high, None, curvature, &mut roots);
                    }
                    None => self.monotone(low, high, None, curvature, &mut roots),
                }
            } else if half < NARROWEST || depth + 2 > stack.len() {
                if self.jet(low)[0] * self.jet(high)[0] < 0.0 {
                    roots.push(middle);
                }
            } else {
                stack[depth] = (low, middle);
                stack[depth + 1] = (middle, high);
                depth += 2;
            }
        }
        roots
    }

    fn monotone(&self, low: f64, high: f64, known: Option<(f64, [f64; 2])>, curvature: f64, roots: &mut Roots) {
        let value = |t: f64| {
            let [f, slope, _] = self.jet(t);
            [f, slope]
        };
        if let Some(t) = bracketed(low, high, known, curvature, value) {
            roots.push(t);
        }
    }

    /// f′, f″ at t.
    fn slopes(&self, t: f64) -> [f64; 2] {
        let [_, slope, bend] = self.jet(t);
        [slope, bend]
    }
}

/// sin and cos, those of sixteenths of a turn from a table: the first cells begin, end and have their middles there.
///
/// The end of the turn is its beginning, to the last bit: a root there lies in one cell, not in none.
fn sin_cos(t: f64) -> (f64, f64) {
    const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
    /// cos π/8.
    const LONG: f64 = 0.923_879_532_511_286_7;
    /// sin π/8.
    const SHORT: f64 = 0.382_683_432_365_089_8;
    const SINES: [f64; 21] = [
        0.0, SHORT, HALF, LONG, 1.0, LONG, HALF, SHORT, 0.0, -SHORT, -HALF, -LONG, -1.0, -LONG, -HALF, -SHORT, 0.0,
        SHORT, HALF, LONG, 1.0,
    ];
    let k = (t * (16.0 / TAU) + 0.5) as usize;
    if k as f64 * (TAU / 16.0) == t { (SINES[k], SINES[k + 4]) } else { t.sin_cos() }
}

/// The sign change of a monotone function between two ends, by Newton steps that a bracket keeps honest.
///
/// - `known`: a place between the ends, and the function there
/// - `bend`: a bound on the size of its second derivative
/// - `function`: value and derivative
/// - returns `None` where the ends have the same sign; a zero counts as positive
fn bracketed(
    mut low: f64,
    mut high: f64,
    known: Option<(f64, [f64; 2])>,
    bend: f64,
    function: impl Fn(f64) -> [f64; 2],
) -> Option<f64> {
    let rising = function(high)[0] >= 0.0;
    if (function(low)[0] >= 0.0) == rising {
        return None;
    }
    let (mut t, [mut value, mut slope]) = known.unwrap_or_else(|| {
        let middle = 0.5 * (low + high);
        (middle, function(middle))
    });
    for _ in 0..80 {
        if (value >= 0.0) == rising {
            high = t;
        } else {
            low = t;
        }
        let newton = t - value / slope;
        let is_newton = newton > low && newton < high;
        let next = if is_newton { newton } else { 0.5 * (low + high) };
        let (step, rounding) = ((next - t).abs(), f64::EPSILON * t.abs().max(1.0));
        // What a Newton step leaves is at most ½ bend step²/slope.
        if step <= rounding || is_newton && bend * step * step <= rounding * slope.abs() {
            return Some(next);
        }
        t = next;
        [value, slope] = function(t);
    }
    Some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Π over pairs of 2 sin((t − r1)/2) sin((t − r2)/2) = cos((r1 − r2)/2) − cos(t − (r1 + r2)/2).
    fn with_roots(r: [f64; 4]) -> Trigonometric {
        let (x, y) = ((0.5 * (r[0] - r[1])).cos(), (0.5 * (r[2] - r[3])).cos());
        let (p, q) = (0.5 * (r[0] + r[1]), 0.5 * (r[2] + r[3]));
        // (x − cos(t − p)) (y − cos(t − q))
        Trigonometric {
            a0: x * y + 0.5 * (p - q).cos(),
            a1: -x * q.cos() - y * p.cos(),
            b1: -x * q.sin() - y * p.sin(),
            a2: 0.5 * (p + q).cos(),
            b2: 0.5 * (p + q).sin(),
        }
    }

    #[test]
    fn all_roots_are_found_even_when_they_crowd() {
        for roots in [
            [0.1, 1.0, 2.5, 6.0],
            [1.0, 1.0001, 4.0, 4.1],
            [2.0, 2.001, 2.003, 5.0],
            [2.0, 2.01, 2.03, 2.04],
            [3.0, 3.0 + 1e-5, 5.0, 5.0 + 1e-6],
        ] {
            let found = with_roots(roots).roots();
            let mut found = found.as_slice().to_vec();
            found.sort_by(f64::total_cmp);
            assert_eq!(found.len(), 4, "{roots:?} gave {found:?}");
            for (a, b) in found.iter().zip(roots) {
                assert!((a - b).abs() < 2e-8, "{roots:?} gave {found:?}");
            }
        }
    }

    #[test]
    fn roots_at_the_ends_of_cells_are_found_once() {
        for k in 0..16 {
            let end = TAU * f64::from(k) / 16.0;
            for nudge in [-2e-16, -1e-16, 0.0, 1e-16, 2e-16] {
                let found = with_roots([end + nudge, end + 0.3, end + 1.0, end + 2.5]).roots();
                assert_eq!(found.as_slice().len(), 4, "{k}: {found:?}");
            }
        }
    }

    #[test]
    fn no_root_is_invented() {
        let none = Trigonometric { a0: 2.1, a1: 1.0, b1: 0.0, a2: 0.5, b2: 0.5 };
        assert!(none.roots().as_slice().is_empty());
    }
}
