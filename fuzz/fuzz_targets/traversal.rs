//! Rays through self-similar DAGs against the exact oracle.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::traversal(data));
