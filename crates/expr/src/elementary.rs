//! `exp`, `ln`, `sin`, `cos` without branches or tables, from double operations with one IEEE 754 rounding
//! each (including fused multiply-add, which is slow without hardware support but gives the same result). A
//! loop over them vectorises, and they give the same bits on every machine and for any number of lanes.
//!
//! The error is below 1 unit in the last place (tested against sums in higher precision; measured: 0.8).
//! The reductions and the form of `ln` are the classical ones (J.-M. Muller, *Elementary Functions*, 3rd
//! ed., 2016, ch. 11; W. J. Cody, W. Waite, *Software Manual for the Elementary Functions*, 1980). The
//! polynomials are Chebyshev fits made for this file.

/// 1.5 * 2^52: its addition rounds a number to an integer, which then is in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// ln 2 in two parts; an integer of up to 20 bits times the first one is exact.
const LN2: (f64, f64) = (0.693_147_180_485_539_1, 7.440_617_110_012_397e-11);

/// pi/2 in three parts; an integer of up to 20 bits times each of the first two is exact.
const HALF_PI: (f64, f64, f64) =
    (1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21);

/// Up to this angle (2^20 quarter turns) the reduction is accurate; the standard library serves beyond it.
const FAR: f64 = 1_647_099.0;

/// `c[0] + c[1] x + ...`
#[inline(always)]
fn polynomial<const N: usize>(c: &[f64; N], x: f64) -> f64 {
    let mut sum = c[N - 1];
    for k in (0..N - 1).rev() {
        sum = sum.mul_add(x, c[k]);
    }
    sum
}

/// 2^k for an integer `k` from -1022 to 1023.
#[inline(always)]
fn power_of_two(k: f64) -> f64 {
    f64::from_bits((k + ROUND).to_bits().wrapping_add(1023) << 52)
}

/// The exponential: `exp(x) = 2^k exp(r)`, |r| <= ln(2)/2.
#[inline(always)]
pub(crate) fn exp(x: f64) -> f64 {
    // Beyond these limits the result is infinite or zero; NaN stays NaN.
    let x = if x > 710.0 { 710.0 } else { x };
    let x = if x < -746.0 { -746.0 } else { x };
    let k = (x * std::f64::consts::LOG2_E + ROUND) - ROUND;
    let r = (x - k * LN2.0) - k * LN2.1;
    // (exp(r) - 1 - r)/r^2, to 1.4e-18
    const Q: [f64; 11] = [
        0.5,
        0.166_666_666_666_666_7,
        0.041_666_666_666_666_67,
        0.008_333_333_333_326_136,
        0.001_388_888_888_888_374_8,
        0.000_198_412_698_748_206_27,
        2.480_158_732_554_774_3e-5,
        2.755_725_540_020_642_2e-6,
        2.755_727_364_311_03e-7,
        2.510_521_700_472_074_5e-8,
        2.091_468_696_808_687_6e-9,
    ];
    let y = 1.0 + (r + r * r * polynomial(&Q, r));
    // Two factors, so that results near the limits of a double are rounded only once.
    let half = (0.5 * k + ROUND) - ROUND;
    y * power_of_two(half) * power_of_two(k - half)
}

/// The natural logarithm: `ln(2^k (1 + f))`, 1 + f between sqrt(1/2) and sqrt(2), as an odd series in f/(2 +
/// f).
#[inline(always)]
pub(crate) fn ln(x: f64) -> f64 {
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    const WHOLE: u64 = 0x4330_0000_0000_0000; // 2^52: small whole numbers stand in its lowest bits
    let subnormal = x < f64::MIN_POSITIVE;
    let scaled = if subnormal { x * 18_014_398_509_481_984.0 } else { x };
    let exponent = scaled.to_bits().wrapping_sub(SQRT_HALF).wrapping_add(1024 << 52) >> 52;
    let k = f64::from_bits(WHOLE | exponent) - (4_503_599_627_370_496.0 + 1024.0);
    let mantissa = f64::from_bits(scaled.to_bits().wrapping_sub(exponent.wrapping_sub(1024) << 52));
    let k = if subnormal { k - 54.0 } else { k };
    let f = mantissa - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    // (2 artanh(s)/s - 2)/s^2, to 2.1e-18
    const L: [f64; 8] = [
        0.666_666_666_666_666_6,
        0.400_000_000_000_008_8,
        0.285_714_285_708_028_5,
        0.222_222_223_918_870_64,
        0.181_817_956_216_327_82,
        0.153_862_407_089_696_65,
        0.132_687_461_955_965_95,
        0.130_869_078_879_650_27,
    ];
    let half = 0.5 * f * f;
    let y = k * LN2.0 - ((half - (s * (half + z * polynomial(&L, z)) + k * LN2.1)) - f);
    let y = if x == f64::INFINITY { x } else { y };
    let y = if x > 0.0 { y } else { f64::NAN };
    if x == 0.0 { f64::NEG_INFINITY } else { y }
}

/// The number of quarter turns (the lowest two bits count) and the remaining angle, in two parts.
#[inline(always)]
fn reduced(x: f64) -> (u64, f64, f64) {
    let turns = x * std::f64::consts::FRAC_2_PI + ROUND;
    let k = turns - ROUND;
    let a = x - k * HALF_PI.0;
    let w = k * HALF_PI.1;
    let b = a - w;
    // The rounding error of the second subtraction, and the third part of pi/2.
    let lost = ((a - b) - w) - k * HALF_PI.2;
    let r = b + lost;
    (turns.to_bits(), r, (b - r) + lost)
}

/// Sine of `x + tail`, |x| <= pi/4.
#[inline(always)]
fn sine(x: f64, tail: f64) -> f64 {
    const S: [f64; 6] = [
        0.008_333_333_333_333_331,
        -0.000_198_412_698_412_650_6,
        2.755_731_921_933_543e-6,
        -2.505_210_623_115_790_4e-8,
        1.605_853_141_458_901e-10,
        -7.586_685_070_091_267e-13,
    ];
    const FIRST: f64 = -0.166_666_666_666_666_66;
    let z = x * x;
    let cube = z * x;
    x - ((z * (0.5 * tail - cube * polynomial(&S, z)) - tail) - cube * FIRST)
}

/// Cosine of `x + tail`, |x| <= pi/4.
#[inline(always)]
fn cosine(x: f64, tail: f64) -> f64 {
    const C: [f64; 7] = [
        0.041_666_666_666_666_664,
        -0.001_388_888_888_888_888_7,
        2.480_158_730_158_464_5e-5,
        -2.755_731_922_140_076e-7,
        2.087_675_579_036_339_7e-9,
        -1.147_046_077_396_932_5e-11,
        4.745_865_203_787_455_3e-14,
    ];
    let z = x * x;
    let half = 0.5 * z;
    let w = 1.0 - half;
    w + (((1.0 - w) - half) + (z * (z * polynomial(&C, z)) - x * tail))
}

/// Sine of `x`, or of `x` plus a quarter turn, for |x| below [`FAR`].
#[inline(always)]
fn near(x: f64, quarter: u64) -> f64 {
    let (turns, r, tail) = reduced(x);
    let turns = turns.wrapping_add(quarter);
    let (s, c) = (sine(r, tail), cosine(r, tail));
    let y = if turns & 1 == 0 { s } else { c };
    f64::from_bits(y.to_bits() ^ ((turns & 2) << 62))
}

/// Sine of an angle in radians.
#[inline(always)]
pub(crate) fn sin(x: f64) -> f64 {
    if x.abs() < FAR { near(x, 0) } else { x.sin() }
}

/// Cosine of an angle in radians.
#[inline(always)]
pub(crate) fn cos(x: f64) -> f64 {
    if x.abs() < FAR { near(x, 1) } else { x.cos() }
}

/// [`sin`] (`quarter` 0) or [`cos`] (1) of many angles: one test whether all are below [`FAR`], then a loop
/// without branches.
#[inline(always)]
pub(crate) fn angles<const N: usize>(quarter: u64, a: &[f64; N], out: &mut [f64; N]) {
    let mut all = true;
    for x in a {
        all &= x.abs() < FAR;
    }
    if all {
        for i in 0..N {
            out[i] = near(a[i], quarter);
        }
    } else {
        for i in 0..N {
            out[i] = if quarter == 0 { sin(a[i]) } else { cos(a[i]) };
        }
    }
}

#[cfg(test)]
mod tests;
