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
//!
//! | feature | adds |
//! | --- | --- |
//! | none | load, check, trace, normals, materials, shade and render over borrowed slices |
//! | `alloc` (default) | voxelisation and builders whose memory grows |
//! | `std` | square roots by the hardware, the same bits; checksums by it, too; vectors by what the machine has ([`simd`]) |
//! | `obj` | readers of OBJ and MTL files, free of I/O |
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "alloc")]
extern crate alloc;
#[cfg(feature = "std")]
extern crate std;

// What all stages share.
pub mod color;
pub mod math;
pub mod morton;
pub mod octahedral;

// From files to meshes.
pub mod grid;
pub mod material;
pub mod mesh;

#[cfg(feature = "alloc")]
pub mod triangulate;

#[cfg(feature = "obj")]
mod text;

#[cfg(feature = "alloc")]
pub mod texture;

#[cfg(feature = "obj")]
pub mod mtl;

#[cfg(feature = "obj")]
pub mod obj;

// From meshes to voxels, to a DAG and its materials.
#[cfg(feature = "alloc")]
pub mod voxelize;

pub mod geometry;

pub mod dag;

pub mod build;

pub mod ssvdag;

pub mod table;

pub mod tree;

pub mod svo;

pub mod rank;

pub mod layout;

pub mod wide;

pub mod ranked;

pub mod materials;

pub mod colors;

pub mod lod;

#[cfg(feature = "alloc")]
pub mod scene;

// From rays to pixels.
pub mod simd;

pub mod trace;

#[cfg(feature = "alloc")]
pub mod trees;

pub mod normal;

pub mod shade;

pub mod effects;

pub mod camera;

pub mod render;

// What the thesis counts.
pub mod thesis;

// At the rim: files, graphics cards, and a scene that comes along.
pub mod file;

pub mod wgsl;

#[cfg(feature = "alloc")]
pub mod demo;

pub use dag::Dag;
pub use geometry::Geometry;
pub use grid::Grid;
pub use material::Material;
pub use materials::Materials;
pub use mesh::Mesh;
pub use morton::Morton;
pub use rank::Rank;
pub use ssvdag::Ssvdag;
pub use table::{Table, TableMut};
pub use tree::Tree;

/// The README's examples are tests.
#[cfg(all(doctest, feature = "alloc"))]
#[doc = include_str!("../../README.md")]
struct ReadmeDoctests;
