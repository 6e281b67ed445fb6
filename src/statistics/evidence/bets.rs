//! The ladder of bets and their shares of the initial capital.

const NEAR: usize = 10;
const FAR: usize = 20;
pub(super) const BETS: usize = NEAR + FAR + 1;
/// Initial capital of one bet of each kind; NEAR · 0.09 + FAR · 0.08/20 + 0.02 = 1.
const WEIGHT_NEAR: f64 = 0.9 / NEAR as f64;
pub(super) const WEIGHT_FAR: f64 = 0.08 / FAR as f64;
pub(super) const WEIGHT_SPREAD: f64 = 0.02;

/// λ√v of the near and far bets, in the order of `Capital`; the spread bet comes last there and has none.
pub(super) fn bets(planned: f64) -> impl Iterator<Item = f64> {
    let near = (0..NEAR / 2).map(move |j| 3.0 * f64::from(1u32 << j) / planned.sqrt());
    let far = (1..=FAR / 2).map(|k| 1.0 / f64::from(1u32 << (2 * k)));
    near.chain(far).flat_map(|bet| [bet, -bet])
}

/// Shares of all bets in that order; they sum to 1.
pub(super) fn weights() -> impl Iterator<Item = f64> {
    let near = std::iter::repeat_n(WEIGHT_NEAR, NEAR);
    near.chain(std::iter::repeat_n(WEIGHT_FAR, FAR)).chain([WEIGHT_SPREAD])
}
