//! The MTL importer: no panic, materials that can be drawn.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::mtl(data));
