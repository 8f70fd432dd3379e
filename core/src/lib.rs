//! Sparse voxel DAGs with materials.
//!
//! Data flows one way, and the modules are listed in that order:
//!
//! ```text
//! OBJ/MTL -> Mesh -> bricks in Morton order -> Dag + Materials -> trace -> normal -> shade -> rows of RGBA8
//! ```
//!
//! The contract: no `unsafe`; no heap without the feature `alloc`; no recursion and no panic on validated data;
//! queries on a [`dag::Dag`] allocate nothing and answer the same bits on every target and for any thread count.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

pub mod math;
pub mod morton;

#[cfg(feature = "alloc")]
pub mod demo;

pub mod grid;
pub mod material;
pub mod mesh;

#[cfg(feature = "alloc")]
pub mod triangulate;

#[cfg(feature = "obj")]
pub mod mtl;
#[cfg(feature = "obj")]
pub mod obj;
#[cfg(feature = "obj")]
mod text;

#[cfg(feature = "alloc")]
pub mod voxelize;

pub mod build;
pub mod dag;
pub mod materials;
pub mod octahedral;
#[cfg(feature = "alloc")]
pub mod scene;
pub mod table;
pub mod trace;

pub mod file;
pub mod normal;

pub mod color;
pub mod shade;

pub mod camera;
pub mod render;

pub use dag::Dag;
pub use grid::Grid;
pub use material::Material;
pub use materials::Materials;
pub use mesh::Mesh;
pub use morton::Morton;
pub use table::{Table, TableMut};

/// The README's examples are tests.
#[cfg(all(doctest, feature = "alloc"))]
#[doc = include_str!("../../README.md")]
struct ReadmeDoctests;
