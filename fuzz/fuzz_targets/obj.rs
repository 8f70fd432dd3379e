//! The OBJ importer: no panic, a mesh in order.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::obj(data));
