//! Where each watt went.
//!
//! Every packet of flux is booked once: emitted = deposited + absorbed + escaped + terminated, to rounding. Whether the
//! deposited share is *right* is another question, a statistical one, for which the ledger has the spread of the deposits.

use std::ops::AddAssign;

/// A sum whose rounding errors are carried along (Neumaier 1974).
///
/// - error: 2⁻⁵³ of the result, and n² · 2⁻¹⁰⁶ of the sum of sizes, for n terms
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Sum {
    sum: f64,
    carried: f64,
}

impl Sum {
    /// The nearest `f64`, or its neighbour.
    pub fn value(&self) -> f64 {
        self.sum + self.carried
    }
}

impl AddAssign<f64> for Sum {
    #[inline(always)]
    fn add_assign(&mut self, term: f64) {
        let sum = self.sum + term;
        self.carried += if self.sum.abs() >= term.abs() { (self.sum - sum) + term } else { (term - sum) + self.sum };
        self.sum = sum;
    }
}

impl AddAssign<Sum> for Sum {
    fn add_assign(&mut self, other: Sum) {
        *self += other.sum;
        *self += other.carried;
    }
}

/// Flux of independent groups of rays, and its spread. A group that brought nothing counts as nought.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub struct Moments {
    /// Σ x, W.
    pub flux: Sum,
    /// Σ x² over groups, W².
    pub squares: f64,
}

impl Moments {
    /// One group's flux, W.
    #[inline(always)]
    pub fn add(&mut self, flux: f64) {
        self.flux += flux;
        self.squares += flux * flux;
    }
    pub fn merge(&mut self, other: &Moments) {
        self.flux += other.flux;
        self.squares += other.squares;
    }
    /// W.
    pub fn watts(&self) -> f64 {
        self.flux.value()
    }
    /// Estimated variance of the sum of n independent groups: n/(n − 1) (Σ x² − (Σ x)²/n), W². `None` below two groups.
    pub fn variance(&self, n_groups: u64) -> Option<f64> {
        let n = n_groups as f64;
        let sum = self.watts();
        (n_groups > 1).then(|| ((self.squares - sum * sum / n) * (n / (n - 1.0))).max(0.0))
    }
    /// Estimated standard deviation of the sum, W. `None` below two groups.
    pub fn std_error(&self, n_groups: u64) -> Option<f64> {
        self.variance(n_groups).map(f64::sqrt)
    }
}

/// The books of one run, W.
#[derive(Clone, Debug, PartialEq)]
pub struct Ledger {
    /// Rays that left the sources.
    pub rays: u64,
    /// Independent groups that they left in.
    pub groups: u64,
    /// The power of all sources in closed form.
    pub source_power: f64,
    /// Carried by the rays as they left.
    pub emitted: f64,
    /// Left on the receiver and the diffuse surfaces.
    pub deposited: f64,
    /// Estimated standard deviation of `deposited`; `None` below two groups.
    pub deposited_std_error: Option<f64>,
    /// By mirrors, occluders, sources, and backs of diffuse surfaces.
    pub absorbed: f64,
    /// Met nothing any more.
    pub escaped: f64,
    /// Beyond the depth limit.
    pub terminated: f64,
}

impl Ledger {
    /// emitted − deposited − absorbed − escaped − terminated, W.
    pub fn residual(&self) -> f64 {
        let mut rest = Sum::default();
        for part in [self.emitted, -self.deposited, -self.absorbed, -self.escaped, -self.terminated] {
            rest += part;
        }
        rest.value()
    }
    /// The residual's size over what was emitted; nought where nothing was.
    pub fn relative_residual(&self) -> f64 {
        if self.emitted == 0.0 { self.residual().abs() } else { (self.residual() / self.emitted).abs() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_terms_are_not_lost() {
        let mut sum = Sum::default();
        sum += 1.0;
        for _ in 0..1_000_000 {
            sum += 1e-17;
        }
        sum += -1.0;
        // What is carried is itself a plain sum of 10⁶ terms: 10⁶ · 2⁻⁵³ of its 10⁻¹¹.
        assert!((sum.value() - 1e-11).abs() < 1.2e-21, "{:e}", sum.value());
        let mut other = Sum::default();
        other += 1e16;
        other += 1.0;
        sum += other;
        sum += -1e16;
        assert!((sum.value() - 1.0 - 1e-11).abs() < 1e-15);
    }

    #[test]
    fn the_spread_is_the_binomials() {
        let mut moments = Moments::default();
        for k in 0..100 {
            moments.add(if k % 4 == 0 { 2.0 } else { 0.0 });
        }
        // 100 · 4 · (1/4)(3/4) · 100/99.
        assert!((moments.variance(100).unwrap() - 75.0 * 100.0 / 99.0).abs() < 1e-12);
        assert_eq!((moments.watts(), Moments::default().variance(1)), (50.0, None));
    }
}
