//! N rooks: Latin hypercube sampling in two dimensions.
//!
//! Point k lies in column π(k) and row ρ(k) of N each, π and ρ independent random permutations, jittered in both. (One
//! permutation would do for the set; the second draws the order.) The variance of a sum of a function of u and a function
//! of v falls as N⁻³, of what is neither as N⁻¹ (Stein, Technometrics 29, 1987).

use super::permutation::Permutation;
use super::{ABREAST, Lanes, Squares};

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
            let mut first = self.next;
            for some in axis[..len].chunks_mut(ABREAST) {
                let mut places = [0; ABREAST];
                let places = &mut places[..some.len()];
                for (k, place) in places.iter_mut().enumerate() {
                    *place = first + k as u64;
                }
                permutation.permute(places);
                for (x, place) in some.iter_mut().zip(places.iter()) {
                    *x = (*place as f64 + *x) * width;
                }
                first += some.len() as u64;
            }
        }
        self.next += len as u64;
    }
}
