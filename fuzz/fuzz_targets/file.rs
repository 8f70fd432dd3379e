//! The loader of `.vxd` files: refused or safe.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::file(data));
