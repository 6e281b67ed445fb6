//! N rooks: Latin hypercube sampling in two dimensions.
//!
//! Point k lies in column π(k) and row ρ(k) of N each, π and ρ independent random permutations, jittered in both. (One
//! permutation would do for the set; the second draws the order.) The variance of a sum of a function of u and a function
//! of v falls as N⁻³, of what is neither as N⁻¹ (Stein, Technometrics 29, 1987).

use super::permutation::Permutation;
use super::{BLOCK, Lanes, Squares};

#[derive(Clone, Debug)]
pub(super) struct LatinHypercube {
    n: u64,
    columns: Permutation,
    rows: Permutation,
    next: u64,
}

impl LatinHypercube {
    pub fn new(n: u64, lanes: &mut Lanes) -> LatinHypercube {
        LatinHypercube { n, columns: Permutation::draw(n, lanes), rows: Permutation::draw(n, lanes), next: 0 }
    }

    /// Moves uniform points into their columns and rows.
    #[inline(always)]
    pub fn jitter(&mut self, squares: &mut Squares, len: usize) {
        let width = 1.0 / self.n as f64;
        let axes = [(squares.u.as_flattened_mut(), &self.columns), (squares.v.as_flattened_mut(), &self.rows)];
        for (axis, permutation) in axes {
            let mut place: [u64; BLOCK] = std::array::from_fn(|k| self.next + k as u64);
            permutation.permute(&mut place[..len]);
            for (x, place) in axis[..len].iter_mut().zip(place) {
                *x = (place as f64 + *x) * width;
            }
        }
        self.next += len as u64;
    }
}
