//! Instruction sets: which ones the processor has, and the one dispatcher that compiles a kernel for each of them.

use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

use crate::simd::{Portable, Simd};

/// An instruction set that kernels are compiled for. All give the same bits; they differ in speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Isa {
    /// What every processor of the target has.
    Portable,
    /// x86-64 with AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
    Avx2,
    /// The above with AVX-512 F, VL, DQ, BW and CD.
    Avx512,
}

impl Isa {
    /// All sets, slowest first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// The best set of this processor.
    pub fn detect() -> Self {
        Self::Avx512.usable()
    }

    /// Every set that this processor can run, slowest first.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|isa| isa.is_available()).collect()
    }

    /// True if this processor can run the set.
    pub fn is_available(self) -> bool {
        self.usable() == self
    }

    /// This set, or the best one below it that the processor has.
    pub(crate) fn usable(self) -> Self {
        // Asked on every call of an accelerator.
        static BEST: OnceLock<Isa> = OnceLock::new();
        self.min(*BEST.get_or_init(Self::best))
    }

    fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            if x86_has_avx512() {
                return Self::Avx512;
            }
            if x86_has_avx2() {
                return Self::Avx2;
            }
        }
        Self::Portable
    }

    /// The name as `Display` writes it and `FromStr` reads it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

impl fmt::Display for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The name is none of `portable`, `avx2`, `avx512`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown instruction set `{0}`: expected `portable`, `avx2` or `avx512`")]
pub struct UnknownIsa(pub String);

impl FromStr for Isa {
    type Err = UnknownIsa;

    fn from_str(name: &str) -> Result<Self, UnknownIsa> {
        Self::ALL.into_iter().find(|isa| isa.name() == name).ok_or_else(|| UnknownIsa(name.to_owned()))
    }
}

/// Work that [`run`] compiles for every instruction set.
pub trait Kernel {
    /// What the work gives.
    type Output;

    /// The work. Mark it, and whatever it calls in its loops, `#[inline(always)]`: only inlined code is compiled for the
    /// chosen set.
    fn run(self) -> Self::Output;
}

/// Runs a kernel compiled for `isa`, or for the best lower set where the processor lacks it. The result does not depend
/// on the set, because the compiler neither fuses nor reorders floating-point operations.
///
/// Call it once per slice of work: the kernel does not inline into the caller.
pub fn run<K: Kernel>(isa: Isa, kernel: K) -> K::Output {
    dispatch(isa, Plain(kernel))
}

/// A kernel that uses the crate's own vector operations.
pub(crate) trait SimdKernel {
    type Output;

    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

struct Plain<K>(K);

impl<K: Kernel> SimdKernel for Plain<K> {
    type Output = K::Output;

    #[inline(always)]
    fn run<S: Simd>(self, _simd: S) -> K::Output {
        self.0.run()
    }
}

/// The dispatcher: every kernel, of this crate or of another, gets its instruction set here.
#[inline]
pub(crate) fn dispatch<K: SimdKernel>(isa: Isa, kernel: K) -> K::Output {
    match isa.usable() {
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => {
            // SAFETY: `usable` gives Avx512 only if the processor has all its features.
            unsafe { crate::simd::x86::run_avx512(kernel) }
        }
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => {
            // SAFETY: `usable` gives Avx2 only if the processor has all its features.
            unsafe { crate::simd::x86::run_avx2(kernel) }
        }
        _ => run_portable(kernel),
    }
}

/// A call of its own, as the others are: what is not run costs the caller nothing.
#[inline(never)]
fn run_portable<K: SimdKernel>(kernel: K) -> K::Output {
    kernel.run(Portable)
}

#[cfg(target_arch = "x86_64")]
fn x86_has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
}

#[cfg(target_arch = "x86_64")]
fn x86_has_avx512() -> bool {
    x86_has_avx2()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512cd")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_round_trip() {
        for isa in Isa::ALL {
            assert_eq!(isa.to_string().parse(), Ok(isa));
        }
        assert!("sse9".parse::<Isa>().is_err());
    }

    #[test]
    fn every_set_runs_or_falls_back() {
        struct Dot<'a>(&'a [f32], &'a [f32]);
        impl Kernel for Dot<'_> {
            type Output = f32;
            #[inline(always)]
            fn run(self) -> f32 {
                self.0.iter().zip(self.1).map(|(a, b)| a * b).fold(0.1, |sum, x| sum * 0.9 + x)
            }
        }
        let a: Vec<f32> = (0..1000).map(|i| 1.0 / (i + 1) as f32).collect();
        let b: Vec<f32> = (0..1000).map(|i| (i as f32).sqrt()).collect();
        let bits: Vec<u32> = Isa::ALL.iter().map(|&isa| run(isa, Dot(&a, &b)).to_bits()).collect();
        assert!(bits.iter().all(|&x| x == bits[0]), "{bits:?}");
        assert!(Isa::available().contains(&Isa::detect()));
        assert_eq!(Isa::available()[0], Isa::Portable);
    }
}
