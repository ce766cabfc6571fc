//! Fuzzes `phisindy_fuzz::gap`.
#![no_main]

/// A search is hundreds of fits.
const LIMITS: phisindy_fuzz::Limits =
    phisindy_fuzz::Limits { milliseconds: 60_000.0, bytes: 512 << 20, again: 0 };

libfuzzer_sys::fuzz_target!(|input: &[u8]| phisindy_fuzz::measured_within(LIMITS, || phisindy_fuzz::gap(
    input
)));
