//! A slab of glass under a point source.

use super::ball::glass_face;
use super::faces::{Loss, Polarised};
use super::fan::Fan;
use super::spherical::of_half_tangent;
use crate::number::{Number, Wide};

/// A level slab of thickness d and index n between a point source and the receiver, h of air in all. After 2k reflections
/// inside, with sin i = n sin r
///
/// ```text
/// ρ = h tan i + (2k + 1) d tan r,   flux = 1 − cos i
/// ```
///
/// The parameter u is tan(i/2).
#[derive(Clone, Copy, Debug)]
pub(super) struct Slab {
    pub air: f64,
    pub thickness: f64,
    pub index: f64,
    pub echoes: u32,
    pub loss: Loss,
}

impl Slab {
    fn way(&self) -> f64 {
        f64::from(2 * self.echoes + 1)
    }
}

impl Fan for Slab {
    fn landing<T: Number>(&self, u: T) -> T {
        let (sin_i, cos_i) = of_half_tangent(u);
        let sin_r = sin_i / T::constant(self.index);
        let cos_r = ((T::constant(1.0) - sin_r) * (sin_r + 1.0)).sqrt();
        sin_i / cos_i * self.air + sin_r / cos_r * self.thickness * self.way()
    }
    fn flux<T: Number>(&self, u: T) -> T {
        u * u * 2.0 / (u * u + 1.0)
    }
    fn share(&self, u: f64) -> f64 {
        if self.is_lossless() {
            return 1.0;
        }
        let [through, back] = glass_face(self.index, of_half_tangent(u).1);
        let echo = |back: f64| back.powi(2 * self.echoes as i32);
        match self.loss {
            Loss::EachFaceUnpolarised => through.mean() * through.mean() * echo(back.mean()),
            _ => through.then(through).then(Polarised { s: echo(back.s), p: echo(back.p) }).mean(),
        }
    }
    fn is_lossless(&self) -> bool {
        self.loss == Loss::None
    }
    /// Just short of the level ray, which never lands.
    fn last(&self) -> Wide {
        Wide::difference(1.0, 2.0_f64.powi(-100))
    }
    fn size(&self) -> f64 {
        self.air + self.thickness
    }
}
