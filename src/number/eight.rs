//! Eight numbers at a time, in the registers that the machine has.
//!
//! A text is written once over [`Lanewise`] and holds for one number (`f64`) and for eight ([`Eight`]). Every operation is
//! one IEEE operation a lane and none are fused, so the width of the registers moves no bit. (Left to itself the compiler
//! makes vectors of some loops and, after the next change, of others.)
//!
//! What runs on wide registers is inlined into one function for each instruction set: closures are not, and have no place in
//! there.

use std::ops::{Add, BitAnd, BitXor, Div, Mul, Neg, Sub};

/// One number or several side by side.
pub(crate) trait Lanewise:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// Which of the numbers.
    type Which: Copy + BitAnd<Output = Self::Which> + BitXor<Output = Self::Which>;

    /// A number, as often as this has lanes.
    fn like(self, x: f64) -> Self;
    fn abs(self) -> Self;
    fn sqrt(self) -> Self;
    fn at_most(self, limit: Self) -> Self;
    fn at_least(self, limit: Self) -> Self;
    /// Not below zero.
    fn positive(self) -> Self;
    fn is_below(self, other: Self) -> Self::Which;
    /// Whether a number is zero of either sign.
    fn is_zero(self) -> Self::Which;
    fn choose(which: Self::Which, yes: Self, no: Self) -> Self;
}

impl Lanewise for f64 {
    type Which = bool;

    #[inline(always)]
    fn like(self, x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn abs(self) -> f64 {
        f64::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn at_most(self, limit: f64) -> f64 {
        self.min(limit)
    }
    #[inline(always)]
    fn at_least(self, limit: f64) -> f64 {
        self.max(limit)
    }
    #[inline(always)]
    fn positive(self) -> f64 {
        self.max(0.0)
    }
    #[inline(always)]
    fn is_below(self, other: f64) -> bool {
        self < other
    }
    #[inline(always)]
    fn is_zero(self) -> bool {
        self == 0.0
    }
    #[inline(always)]
    fn choose(which: bool, yes: f64, no: f64) -> f64 {
        if which { yes } else { no }
    }
}

/// Registers that hold eight numbers.
pub(crate) trait Registers: Copy {
    type Values: Copy;
    type Which: Copy;

    fn splat(self, x: f64) -> Self::Values;
    fn load(self, from: &[f64; 8]) -> Self::Values;
    fn store(self, values: Self::Values, to: &mut [f64; 8]);
    fn add(self, a: Self::Values, b: Self::Values) -> Self::Values;
    fn sub(self, a: Self::Values, b: Self::Values) -> Self::Values;
    fn mul(self, a: Self::Values, b: Self::Values) -> Self::Values;
    fn div(self, a: Self::Values, b: Self::Values) -> Self::Values;
    fn neg(self, a: Self::Values) -> Self::Values;
    fn abs(self, a: Self::Values) -> Self::Values;
    fn sqrt(self, a: Self::Values) -> Self::Values;
    fn min(self, a: Self::Values, b: Self::Values) -> Self::Values;
    fn max(self, a: Self::Values, b: Self::Values) -> Self::Values;
    fn less(self, a: Self::Values, b: Self::Values) -> Self::Which;
    fn equal(self, a: Self::Values, b: Self::Values) -> Self::Which;
    fn and(self, a: Self::Which, b: Self::Which) -> Self::Which;
    fn xor(self, a: Self::Which, b: Self::Which) -> Self::Which;
    fn choose(self, which: Self::Which, yes: Self::Values, no: Self::Values) -> Self::Values;
}

/// Eight numbers.
#[derive(Clone, Copy)]
pub(crate) struct Eight<R: Registers>(R, R::Values);

/// Which of eight numbers.
#[derive(Clone, Copy)]
pub(crate) struct WhichOfEight<R: Registers>(R, R::Which);

impl<R: Registers> Eight<R> {
    #[inline(always)]
    pub(crate) fn load(registers: R, from: &[f64; 8]) -> Eight<R> {
        Eight(registers, registers.load(from))
    }
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f64; 8]) {
        self.0.store(self.1, to);
    }
}

macro_rules! operation {
    ($trait:ident, $method:ident, $operation:ident) => {
        impl<R: Registers> $trait for Eight<R> {
            type Output = Eight<R>;
            #[inline(always)]
            fn $method(self, other: Eight<R>) -> Eight<R> {
                Eight(self.0, self.0.$operation(self.1, other.1))
            }
        }
        impl<R: Registers> $trait<f64> for Eight<R> {
            type Output = Eight<R>;
            #[inline(always)]
            fn $method(self, other: f64) -> Eight<R> {
                Eight(self.0, self.0.$operation(self.1, self.0.splat(other)))
            }
        }
    };
}
operation!(Add, add, add);
operation!(Sub, sub, sub);
operation!(Mul, mul, mul);
operation!(Div, div, div);

impl<R: Registers> Neg for Eight<R> {
    type Output = Eight<R>;
    #[inline(always)]
    fn neg(self) -> Eight<R> {
        Eight(self.0, self.0.neg(self.1))
    }
}

impl<R: Registers> BitAnd for WhichOfEight<R> {
    type Output = WhichOfEight<R>;
    #[inline(always)]
    fn bitand(self, other: WhichOfEight<R>) -> WhichOfEight<R> {
        WhichOfEight(self.0, self.0.and(self.1, other.1))
    }
}

impl<R: Registers> BitXor for WhichOfEight<R> {
    type Output = WhichOfEight<R>;
    #[inline(always)]
    fn bitxor(self, other: WhichOfEight<R>) -> WhichOfEight<R> {
        WhichOfEight(self.0, self.0.xor(self.1, other.1))
    }
}

impl<R: Registers> Lanewise for Eight<R> {
    type Which = WhichOfEight<R>;

    #[inline(always)]
    fn like(self, x: f64) -> Eight<R> {
        Eight(self.0, self.0.splat(x))
    }
    #[inline(always)]
    fn abs(self) -> Eight<R> {
        Eight(self.0, self.0.abs(self.1))
    }
    #[inline(always)]
    fn sqrt(self) -> Eight<R> {
        Eight(self.0, self.0.sqrt(self.1))
    }
    #[inline(always)]
    fn at_most(self, limit: Eight<R>) -> Eight<R> {
        Eight(self.0, self.0.min(self.1, limit.1))
    }
    #[inline(always)]
    fn at_least(self, limit: Eight<R>) -> Eight<R> {
        Eight(self.0, self.0.max(self.1, limit.1))
    }
    #[inline(always)]
    fn positive(self) -> Eight<R> {
        self.at_least(self.like(0.0))
    }
    #[inline(always)]
    fn is_below(self, other: Eight<R>) -> WhichOfEight<R> {
        WhichOfEight(self.0, self.0.less(self.1, other.1))
    }
    #[inline(always)]
    fn is_zero(self) -> WhichOfEight<R> {
        WhichOfEight(self.0, self.0.equal(self.1, self.0.splat(0.0)))
    }
    #[inline(always)]
    fn choose(which: WhichOfEight<R>, yes: Eight<R>, no: Eight<R>) -> Eight<R> {
        Eight(yes.0, yes.0.choose(which.1, yes.1, no.1))
    }
}

/// Any machine: what the compiler makes of arrays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrays;

macro_rules! lane_by_lane {
    ($($method:ident($a:ident $(, $b:ident)?) = $value:expr;)*) => {$(
        #[inline(always)]
        fn $method(self, left: [f64; 8] $(, $b: [f64; 8])?) -> [f64; 8] {
            let mut out = [0.0; 8];
            for lane in 0..8 {
                let $a = left[lane];
                $(let $b = $b[lane];)?
                out[lane] = $value;
            }
            out
        }
    )*};
}

macro_rules! which_by_lane {
    ($($method:ident($type:ty) = $operator:tt;)*) => {$(
        #[inline(always)]
        fn $method(self, a: [$type; 8], b: [$type; 8]) -> [bool; 8] {
            let mut out = [false; 8];
            for lane in 0..8 {
                out[lane] = a[lane] $operator b[lane];
            }
            out
        }
    )*};
}

impl Registers for Arrays {
    type Values = [f64; 8];
    type Which = [bool; 8];

    #[inline(always)]
    fn splat(self, x: f64) -> [f64; 8] {
        [x; 8]
    }
    #[inline(always)]
    fn load(self, from: &[f64; 8]) -> [f64; 8] {
        *from
    }
    #[inline(always)]
    fn store(self, values: [f64; 8], to: &mut [f64; 8]) {
        *to = values;
    }
    lane_by_lane! {
        add(a, b) = a + b;
        sub(a, b) = a - b;
        mul(a, b) = a * b;
        div(a, b) = a / b;
        min(a, b) = a.min(b);
        max(a, b) = a.max(b);
        neg(a) = -a;
        abs(a) = a.abs();
        sqrt(a) = a.sqrt();
    }
    which_by_lane! {
        less(f64) = <;
        equal(f64) = ==;
        and(bool) = &;
        xor(bool) = ^;
    }
    #[inline(always)]
    fn choose(self, which: [bool; 8], yes: [f64; 8], no: [f64; 8]) -> [f64; 8] {
        let mut out = no;
        for lane in 0..8 {
            out[lane] = if which[lane] { yes[lane] } else { no[lane] };
        }
        out
    }
}

#[cfg(all(feature = "fast", target_arch = "x86_64"))]
const ALL_BUT_THE_SIGN: f64 = f64::from_bits(u64::MAX >> 1);

/// Vector registers, by `pulp`.
#[cfg(all(feature = "fast", target_arch = "x86_64"))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors<S>(S);

#[cfg(all(feature = "fast", target_arch = "x86_64"))]
impl<S: pulp::Simd<f64s = pulp::f64x8>> Registers for Vectors<S> {
    type Values = pulp::f64x8;
    type Which = S::m64s;

    #[inline(always)]
    fn splat(self, x: f64) -> pulp::f64x8 {
        self.0.splat_f64s(x)
    }
    #[inline(always)]
    fn load(self, from: &[f64; 8]) -> pulp::f64x8 {
        pulp::cast(*from)
    }
    #[inline(always)]
    fn store(self, values: pulp::f64x8, to: &mut [f64; 8]) {
        *to = pulp::cast(values);
    }
    #[inline(always)]
    fn add(self, a: pulp::f64x8, b: pulp::f64x8) -> pulp::f64x8 {
        self.0.add_f64s(a, b)
    }
    #[inline(always)]
    fn sub(self, a: pulp::f64x8, b: pulp::f64x8) -> pulp::f64x8 {
        self.0.sub_f64s(a, b)
    }
    #[inline(always)]
    fn mul(self, a: pulp::f64x8, b: pulp::f64x8) -> pulp::f64x8 {
        self.0.mul_f64s(a, b)
    }
    #[inline(always)]
    fn div(self, a: pulp::f64x8, b: pulp::f64x8) -> pulp::f64x8 {
        self.0.div_f64s(a, b)
    }
    #[inline(always)]
    fn neg(self, a: pulp::f64x8) -> pulp::f64x8 {
        self.0.neg_f64s(a)
    }
    #[inline(always)]
    fn abs(self, a: pulp::f64x8) -> pulp::f64x8 {
        // The crate's own is a call where little is optimised.
        self.0.and_f64s(a, self.0.splat_f64s(ALL_BUT_THE_SIGN))
    }
    #[inline(always)]
    fn sqrt(self, a: pulp::f64x8) -> pulp::f64x8 {
        self.0.sqrt_f64s(a)
    }
    #[inline(always)]
    fn min(self, a: pulp::f64x8, b: pulp::f64x8) -> pulp::f64x8 {
        self.0.min_f64s(a, b)
    }
    #[inline(always)]
    fn max(self, a: pulp::f64x8, b: pulp::f64x8) -> pulp::f64x8 {
        self.0.max_f64s(a, b)
    }
    #[inline(always)]
    fn less(self, a: pulp::f64x8, b: pulp::f64x8) -> S::m64s {
        self.0.less_than_f64s(a, b)
    }
    #[inline(always)]
    fn equal(self, a: pulp::f64x8, b: pulp::f64x8) -> S::m64s {
        self.0.equal_f64s(a, b)
    }
    #[inline(always)]
    fn and(self, a: S::m64s, b: S::m64s) -> S::m64s {
        self.0.and_m64s(a, b)
    }
    #[inline(always)]
    fn xor(self, a: S::m64s, b: S::m64s) -> S::m64s {
        self.0.xor_m64s(a, b)
    }
    #[inline(always)]
    fn choose(self, which: S::m64s, yes: pulp::f64x8, no: pulp::f64x8) -> pulp::f64x8 {
        self.0.select_f64s(which, yes, no)
    }
}

/// Something to be done in the widest registers at hand.
pub(crate) trait Work {
    type Output;
    fn run<R: Registers>(self, registers: R) -> Self::Output;
}

/// What this machine has, asked once.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Machine {
    Any,
    #[cfg(all(feature = "fast", target_arch = "x86_64"))]
    Avx2(pulp::x86::V3),
    #[cfg(all(feature = "fast", target_arch = "x86_64"))]
    Avx512(pulp::x86::V4),
}

impl Machine {
    #[cfg(all(feature = "fast", target_arch = "x86_64"))]
    pub(crate) fn new() -> Machine {
        match (pulp::x86::V4::try_new(), pulp::x86::V3::try_new()) {
            (Some(registers), _) => Machine::Avx512(registers),
            (None, Some(registers)) => Machine::Avx2(registers),
            (None, None) => Machine::Any,
        }
    }
    #[cfg(not(all(feature = "fast", target_arch = "x86_64")))]
    pub(crate) fn new() -> Machine {
        Machine::Any
    }

    /// Every machine that this one can stand for.
    #[cfg(all(test, feature = "fast", target_arch = "x86_64"))]
    pub(crate) fn all() -> Vec<Machine> {
        let narrow = pulp::x86::V3::try_new().map(Machine::Avx2);
        let wide = pulp::x86::V4::try_new().map(Machine::Avx512);
        [Some(Machine::Any), narrow, wide].into_iter().flatten().collect()
    }
    #[cfg(all(test, not(all(feature = "fast", target_arch = "x86_64"))))]
    pub(crate) fn all() -> Vec<Machine> {
        vec![Machine::Any]
    }

    /// Does it, compiled for these registers.
    pub(crate) fn run<W: Work>(self, work: W) -> W::Output {
        match self {
            Machine::Any => work.run(Arrays),
            #[cfg(all(feature = "fast", target_arch = "x86_64"))]
            Machine::Avx2(registers) => registers.vectorize(In(Vectors(pulp::x86::V3_512b(registers)), work)),
            #[cfg(all(feature = "fast", target_arch = "x86_64"))]
            Machine::Avx512(registers) => registers.vectorize(In(Vectors(registers), work)),
        }
    }
}

/// Work, and the registers to do it in.
#[cfg(all(feature = "fast", target_arch = "x86_64"))]
struct In<R, W>(R, W);

#[cfg(all(feature = "fast", target_arch = "x86_64"))]
impl<R: Registers, W: Work> pulp::NullaryFnOnce for In<R, W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.1.run(self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation once, on numbers of all kinds.
    struct Everything([f64; 8], [f64; 8]);

    impl Work for Everything {
        type Output = Vec<[f64; 8]>;

        #[inline(always)]
        fn run<R: Registers>(self, registers: R) -> Vec<[f64; 8]> {
            let (a, b) = (Eight::load(registers, &self.0), Eight::load(registers, &self.1));
            let either = a.is_below(b) ^ (a.is_zero() & b.is_below(a));
            let mut out = Vec::new();
            for value in [
                a + b,
                a - b,
                a * b,
                a / b,
                -a,
                a.abs(),
                a.abs().sqrt(),
                a.at_most(b),
                a.at_least(b),
                a.positive() + 0.0,
                a * 3.0 - 1.0,
                Eight::choose(either, a, b),
                a.like(0.1),
            ] {
                let mut row = [0.0; 8];
                value.store(&mut row);
                out.push(row);
            }
            out
        }
    }

    #[test]
    fn every_machine_has_the_same_bits_as_one_number_at_a_time() {
        let a = [0.0, -0.0, 1.0, -1.5, 1e-310, 3e307, -7.25, 0.1];
        let b = [-1.0, 2.0, 1.0, 1.5, 1e-300, -2e307, 1e16, 0.3];
        for machine in Machine::all() {
            let rows = machine.run(Everything(a, b));
            for lane in 0..8 {
                let (x, y) = (a[lane], b[lane]);
                let either = Lanewise::is_below(x, y) ^ (x.is_zero() & Lanewise::is_below(y, x));
                let one = [
                    x + y,
                    x - y,
                    x * y,
                    x / y,
                    -x,
                    Lanewise::abs(x),
                    Lanewise::sqrt(x.abs()),
                    x.at_most(y),
                    x.at_least(y),
                    x.positive() + 0.0,
                    x * 3.0 - 1.0,
                    Lanewise::choose(either, x, y),
                    0.1,
                ];
                let eight: Vec<u64> = rows.iter().map(|row| row[lane].to_bits()).collect();
                assert_eq!(eight, one.map(f64::to_bits), "{machine:?}, lane {lane}");
            }
        }
    }
}
