//! Exact oracles, naive twins and laws for voxdag.
