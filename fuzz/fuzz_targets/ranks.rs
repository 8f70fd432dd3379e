//! Ranks against counting, and any words as prefix counts.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::ranks(data));
