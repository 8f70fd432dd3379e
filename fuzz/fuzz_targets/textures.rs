//! Textures: no panic, colours that depend on no order.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::textures(data));
