//! Picture files: no panic, no more memory than allowed.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::pictures(data));
