//! Random variables for the tests of this room, with their moments.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::budget::seed_of;

/// A stream of numbers that belongs to one test.
pub struct Draws(Xoshiro256PlusPlus);

impl Draws {
    pub fn named(test: &str) -> Draws {
        Draws(Xoshiro256PlusPlus::seed_from_u64(seed_of(test)))
    }

    /// In [0, 1).
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    /// Mean 0, variance 1 (Box and Muller).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }

    /// Mean 1, variance 1.
    pub fn exponential(&mut self) -> f64 {
        -(1.0 - self.uniform()).ln()
    }

    /// 1 with probability p, else 0: mean p, variance p(1 − p).
    pub fn hit(&mut self, p: f64) -> f64 {
        if self.uniform() < p { 1.0 } else { 0.0 }
    }
}
