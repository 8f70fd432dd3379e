//! The SSVDAG against the plain DAG, and any words as an SSVDAG.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::ssvdag(data));
