//! Sparse voxel DAGs with materials.
//!
//! Data flows one way, and the modules are listed in that order:
//!
//! ```text
//! OBJ/MTL -> Mesh -> bricks in Morton order -> Dag + Materials -> trace -> normal -> shade -> rows of RGBA8
//! ```
//!
//! # The contract
//!
//! - **No `unsafe`** in this crate: the compiler forbids it.
//! - **No heap** without the feature `alloc`; with it what builds, reads or writes files, or is named `...Buf` allocates. Queries and
//!   drawing never do (tested by an allocator that aborts). Where memory runs out, builders say so; only the readers of OBJ,
//!   MTL and pictures, and `demo`, end the program as Rust's collections do.
//! - **No panic** on validated data: what reads words from outside ([`file::read`], [`Dag::new`], [`Tree::new`] and their
//!   like) checks all that queries rely on, in time proportional to the words; after that no ray, voxel, node number or
//!   setting can make a query panic, overflow or loop. Queries do not recurse.
//! - **A bound on the stack**: a single ray, its normal and its shading take less than 4.5 KiB on a 32-bit microcontroller
//!   (measured by `tests/bare`, which draws a picture in 96 KiB of flash and 8 KiB of RAM); many rays by vectors up
//!   to 100 KiB, many normals 20 KiB; [`render::render_rows`] 200 KiB, and 350 KiB where rays go on from surfaces (`tests/stack.rs`).
//! - **Determinism**: the same input gives the same bits on every target, for any number of threads, any order of
//!   triangles and any way of cutting the work into parts. Floats are used with `+ - * /`, square roots and `libm` alone.
//! - **Exact answers**: a ray meets the first filled voxel of the real line through its six numbers. What is cheaper and not
//!   exact has a name ([`trace::Arithmetic`]).
//!
//! | feature | adds |
//! | --- | --- |
//! | none | load, check, trace, normals, materials, shade and render over borrowed slices; shaders for graphics cards ([`wgsl`]) |
//! | `alloc` (default) | voxelisation and builders whose memory grows |
//! | `std` | square roots by the hardware, the same bits; checksums by it, too; vectors by what the machine has ([`simd`]) |
//! | `obj` | readers of OBJ and MTL files, free of I/O |
//! | `images` | decoders of the textures that they name: PNG, JPEG, BMP, TGA |
//!
//! # Units
//!
//! Rays run in grid coordinates: voxel k spans k to k + 1 on each axis. [`Grid`] leads there from the world and back. Times
//! are in units of the ray's direction, angles in degrees, colours linear red, green and blue, pictures RGBA8 in rows from
//! the top. A [`Morton`] code holds x in its lowest bit, then y, then z.
//!
//! Examples for engines: `core/examples`; C and C++: `core/capi`. Versions follow SemVer as `CHANGELOG.md` says.
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
