//! Blending from texel to texel along one direction of a map, so that no light is gained or lost.
//!
//! Along a coordinate in which the surface's area is even (s, and the share of the area below a t), texel k is an interval
//! of width w_k. Over the border between two texels their values are blended linearly, up to m = ½ min(w_k, w_{k+1}) on
//! either side of it: what the one gives up over its m metres the other gives up over the same m, so that each texel's weight,
//! integrated over the surface, stays w_k, and the weights at any place add up to one. Where texels are of one width this is
//! the usual bilinear interpolation between their middles.
//!
//! At an end that is a single point of the surface (a pole) a texel is blended within its half there with the mean of its
//! row, to which it comes down at the pole itself. The mean of the row along the row is what it was.

/// How one direction of a map is blended.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// n + 1 of them, from 0 to 1.
    borders: Vec<f64>,
    /// How far the blending over each border reaches to either side; 0 where there is none.
    reach: Vec<f64>,
    wraps: bool,
}

/// What a place on an axis reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Blend {
    /// The texel that it lies in, with one minus the weights below.
    pub own: usize,
    pub other: usize,
    pub other_weight: f64,
    /// Weight of the mean of the row.
    pub pole_weight: f64,
}

impl Axis {
    /// - `borders`: ascending from 0 to 1, at least two
    /// - `wraps`: the last texel is a neighbour of the first; not together with poles
    /// - `poles`: whether the first border, and the last, is a single point of the surface
    pub fn new(borders: Vec<f64>, wraps: bool, poles: [bool; 2]) -> Axis {
        let n = borders.len() - 1;
        let half = |k: usize| 0.5 * (borders[k + 1] - borders[k]);
        let reach = |k: usize| {
            if wraps && (k == 0 || k == n) {
                half(0).min(half(n - 1))
            } else if k == 0 {
                if poles[0] { half(0) } else { 0.0 }
            } else if k == n {
                if poles[1] { half(n - 1) } else { 0.0 }
            } else {
                half(k - 1).min(half(k))
            }
        };
        let reach = (0..=n).map(reach).collect();
        Axis { borders, reach, wraps }
    }

    /// - `own`: the texel that `at` lies in
    #[inline]
    pub fn blend(&self, own: usize, at: f64) -> Blend {
        let last = self.borders.len() - 2;
        let (below, above) = (at - self.borders[own], self.borders[own + 1] - at);
        // Up to its half on either side: never both. Where neither is near, the share is one or more, and the weight nought.
        let is_low = below < self.reach[own];
        let (k, off) = if is_low { (own, below) } else { (own + 1, above) };
        let reach = self.reach[k];
        let share = if off < reach { (off / reach).max(0.0) } else { 1.0 };
        let other = match (is_low, self.wraps) {
            (true, _) if own > 0 => own - 1,
            (false, _) if own < last => own + 1,
            (true, true) => last,
            (false, true) => 0,
            // An end of the surface: a pole, or an edge whose reach is nought.
            _ => return Blend { own, other: own, other_weight: 0.0, pole_weight: 1.0 - share },
        };
        Blend { own, other, other_weight: 0.5 * (1.0 - share), pole_weight: 0.0 }
    }

    /// Where the weights' slopes change, ascending, within (0, 1) or at the ends.
    pub fn bends(&self) -> Vec<f64> {
        let n = self.borders.len() - 1;
        let mut bends: Vec<f64> = (0..=n)
            .flat_map(|k| [self.borders[k] - self.reach[k], self.borders[k] + self.reach[k]])
            .filter(|x| *x > 0.0 && *x < 1.0)
            .collect();
        bends.sort_by(f64::total_cmp);
        // Middles, that two borders have in common.
        bends.dedup_by(|b, a| *b - *a <= 4.0 * f64::EPSILON);
        bends
    }
}
