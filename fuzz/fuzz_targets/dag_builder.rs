//! The DAG builders against a set of voxels.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::dag_builder(data));
