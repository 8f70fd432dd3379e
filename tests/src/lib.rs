//! The home of truth: exact oracles, naive twins and textbook methods that the core is tested against.
//!
//! Nothing here shares a method or code with the core beyond its public types: overlap is rational clipping (the core:
//! integer separating axes), rays are big rationals (the core: filtered floats and expansions), octrees are lists.
//! Slow and obvious is right here. Everything random is seeded; a failing test prints its seed or its input.

pub mod num;
pub mod rng;

pub mod clip;
pub mod thin;

pub mod brute;
pub mod ray;

pub mod eigen;
pub mod mirrors;
pub mod octree;
pub mod scenes;
pub mod subject;
pub mod table;
pub mod textbook;

pub mod laws;
pub mod selftest;
