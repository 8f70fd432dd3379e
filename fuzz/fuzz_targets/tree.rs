//! The material tree against a map, and any words as a tree.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::tree(data));
