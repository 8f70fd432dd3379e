//! Polygons into triangles: area kept, n - 2 of them.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::triangulation(data));
