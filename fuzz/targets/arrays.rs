//! Fuzzes `phisindy_fuzz::arrays`.
#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| phisindy_fuzz::measured(|| phisindy_fuzz::arrays(input)));
