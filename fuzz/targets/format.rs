//! Fuzzes `phisindy_fuzz::format`.
#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| phisindy_fuzz::measured(|| phisindy_fuzz::format(input)));
