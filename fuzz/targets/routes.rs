//! Fuzzes `phisindy_fuzz::routes`.
#![no_main]

/// A body is kept in memory only as far as it was sent, whatever length its head claims.
const LIMITS: phisindy_fuzz::Limits =
    phisindy_fuzz::Limits { milliseconds: 1000.0, bytes: 8 << 20, again: 3 };

libfuzzer_sys::fuzz_target!(|input: &[u8]| phisindy_fuzz::measured_within(LIMITS, || phisindy_fuzz::routes(
    input
)));
