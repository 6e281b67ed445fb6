//! The ladder of bets and their shares of the initial capital.

const NEAR: usize = 10;
const FAR: usize = 20;
pub(super) const BETS: usize = NEAR + FAR + 1;
/// Initial capital of one bet of each kind, as natural logarithms: 9/10 is shared by the near bets, 8/100 by the far ones,
/// and 2/100 is the spread bet's.
const LN_SHARE_NEAR: f64 = -2.407_945_608_651_872; // ln 0.09
pub(super) const LN_SHARE_FAR: f64 = -5.521_460_917_862_246; // ln 0.004
pub(super) const LN_SHARE_SPREAD: f64 = -3.912_023_005_428_146; // ln 0.02

/// λ√v of the near and far bets, in the order of `Capital`; the spread bet comes last there and has none.
pub(super) fn bets(planned: f64) -> impl Iterator<Item = f64> {
    let near = (0..NEAR / 2).map(move |j| 3.0 * f64::from(1u32 << j) / planned.sqrt());
    let far = (1..=FAR / 2).map(|k| 1.0 / f64::from(1u32 << (2 * k)));
    near.chain(far).flat_map(|bet| [bet, -bet])
}

/// Natural logarithms of the shares of all bets in that order; the shares sum to 1.
pub(super) fn ln_shares() -> impl Iterator<Item = f64> {
    let near = std::iter::repeat_n(LN_SHARE_NEAR, NEAR);
    near.chain(std::iter::repeat_n(LN_SHARE_FAR, FAR)).chain([LN_SHARE_SPREAD])
}
