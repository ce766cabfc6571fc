//! Fuzzes `phisindy_fuzz::border`.
#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| phisindy_fuzz::measured(|| phisindy_fuzz::border(input)));
