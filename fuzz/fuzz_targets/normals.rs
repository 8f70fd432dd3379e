//! Normals against integers and Jacobi's eigenvectors.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| voxdag_oracle::laws::normals(data));
