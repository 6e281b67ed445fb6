//! The unit square cut into texels.

use super::ParametrisationError;

/// ns × nt texels over the unit square: ns columns along s, nt rows along t.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TexelGrid {
    ns: usize,
    nt: usize,
}

/// One texel: column i from s = 0, row j from t = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Texel {
    pub i: usize,
    pub j: usize,
}

impl TexelGrid {
    /// Most columns, and most rows.
    pub const MAX_SIDE: usize = 1 << 16;

    /// - `ns`, `nt`: from 1 to [`TexelGrid::MAX_SIDE`]
    pub fn new(ns: usize, nt: usize) -> Result<TexelGrid, ParametrisationError> {
        let accepted = 1..=TexelGrid::MAX_SIDE;
        if accepted.contains(&ns) && accepted.contains(&nt) {
            Ok(TexelGrid { ns, nt })
        } else {
            Err(ParametrisationError::NoTexels { ns, nt })
        }
    }
    /// Columns.
    pub fn ns(self) -> usize {
        self.ns
    }
    /// Rows.
    pub fn nt(self) -> usize {
        self.nt
    }
    /// How many texels there are; at least 1.
    pub fn n_texels(self) -> usize {
        self.ns * self.nt
    }
    /// All of them, s fastest, in the order of [`TexelGrid::index`].
    pub fn texels(self) -> impl Iterator<Item = Texel> {
        (0..self.n_texels()).map(move |k| Texel { i: k % self.ns, j: k / self.ns })
    }
    /// Place of a texel in an array `[nt][ns]`.
    pub fn index(self, texel: Texel) -> usize {
        texel.j * self.ns + texel.i
    }
    /// The texel that holds (s, t). A border belongs to the texel above it; what lies outside the square (or is no number)
    /// belongs to the nearest texel.
    pub fn texel(self, [s, t]: [f64; 2]) -> Texel {
        let place = |x: f64, n: usize| ((x * n as f64).max(0.0) as usize).min(n - 1);
        Texel { i: place(s, self.ns), j: place(t, self.nt) }
    }
    /// Where a texel begins and ends: [[s₀, s₁], [t₀, t₁]].
    pub fn extent(self, texel: Texel) -> [[f64; 2]; 2] {
        let side = |k: usize, n: usize| [k as f64 / n as f64, (k + 1) as f64 / n as f64];
        [side(texel.i, self.ns), side(texel.j, self.nt)]
    }
}
