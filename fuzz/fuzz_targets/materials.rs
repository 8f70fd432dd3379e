//! Every representation of materials against a map, and any words as one.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::materials(data));
