//! Rays on a graphics card: WGSL that reads a scene's words as they are, and the numbers that it needs to find its way.
//!
//! In: a checked `.vxd` file or DAG. Out: [`SOURCE`], to be put before a host's own shader, and the words of the uniform
//! `vd_scene`. The scene's words go into one storage buffer, unchanged. Integers of 32 bits decide the walk, so that hits are
//! those of [`Tracer`](crate::trace::Tracer) for the same six f32, on any card. How to bind and call it, what it costs and
//! where it ends: docs/gpu.md.
//!
//! ```text
//! group(0) binding(0)  storage, read   vd_words: array<u32>    a file's words, or a DAG's
//!          binding(1)  uniform         vd_scene: VdScene       16 words, of `scene` or `dag`:
//! word  0  start of the DAG      4  number of materials       8  pairs           12  patterns
//!       1  depth                 5  material of all voxels    9  small bricks    13  halves
//!       2  root in the DAG, or 0 6  start of the tree, or 0  10  middle bricks   14  levels with wide places
//!       3  start of materials    7  its nodes                11  large bricks    15  0
//! ```

use crate::Dag;
use crate::file::{self, LoadError, Section};
use crate::layout::AnyGeometry;
use crate::materials::AnyMaterials;

/// The functions: `vd_trace`, `vd_occluded`, `vd_contains`, `vd_normal`, `vd_material` and what they need. All names begin
/// with `vd_`, `Vd` or `VD_`.
pub const SOURCE: &str = concat!(
    include_str!("scene.wgsl"),
    "\n",
    include_str!("integer.wgsl"),
    "\n",
    include_str!("trace.wgsl"),
    "\n",
    include_str!("normal.wgsl"),
    "\n",
    include_str!("material.wgsl"),
);

/// An example of what a host adds: `vd_draw` draws a picture by Phong's model. To be put behind [`SOURCE`].
pub const PICTURE: &str = include_str!("picture.wgsl");

/// Words of the uniform `vd_scene`.
pub const SCENE_WORDS: usize = 16;

/// Why a file's words cannot be used on a graphics card.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum WgslError {
    /// They are no scene.
    Load(LoadError),
    /// The shader does not read this section: it takes a DAG, and a material tree or one material for all.
    Unsupported {
        /// The section.
        section: Section,
    },
    /// More than 2^30 words, whose bytes 32 bits cannot count.
    TooLarge {
        /// Words there are.
        found: u64,
    },
}

impl core::fmt::Display for WgslError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            WgslError::Load(error) => error.fmt(f),
            WgslError::Unsupported { section } => {
                write!(f, "the shader does not read the section {section}: expected a DAG with a material tree or none")
            }
            WgslError::TooLarge { found } => write!(f, "the scene has {found} words: expected at most 2^30"),
        }
    }
}

impl core::error::Error for WgslError {}

/// The uniform for a file's words, which are checked as by [`file::read`]. O(words).
///
/// Colours of textures and the materials' opacity are there to be read, but [`SOURCE`] has no use for them.
pub fn scene(words: &[u32]) -> Result<[u32; SCENE_WORDS], WgslError> {
    let scene = file::read(words).map_err(WgslError::Load)?;
    if words.len() > 1 << 30 {
        return Err(WgslError::TooLarge { found: words.len() as u64 });
    }
    let AnyGeometry::Dag(geometry) = scene.geometry else {
        return Err(WgslError::Unsupported { section: Section::Ssvdag });
    };
    // A section that is not there starts at 0, where nothing does but the file.
    let start = |section: Section| file::section_start(words, section).unwrap_or(0);
    let mut uniform = dag(geometry);
    uniform[0] = start(Section::Dag);
    uniform[3] = start(Section::Materials);
    uniform[4] = scene.material_count() as u32;
    match scene.materials {
        AnyMaterials::Single(single) => uniform[5] = u32::from(single.0),
        AnyMaterials::Tree(tree) => {
            let first = start(Section::Tree);
            uniform[6] = first;
            for (word, part) in uniform[7..14].iter_mut().zip(tree.parts()) {
                *word = first + part;
            }
            uniform[14] = tree.wide();
        }
        AnyMaterials::Table(_) => return Err(WgslError::Unsupported { section: Section::Table }),
        _ => return Err(WgslError::Unsupported { section: Section::Ids }),
    }
    Ok(uniform)
}

/// The uniform for a DAG's own words, without materials: every voxel has material 0, and there are no records.
pub fn dag(dag: Dag<'_>) -> [u32; SCENE_WORDS] {
    let mut uniform = [0; SCENE_WORDS];
    uniform[1] = u32::from(dag.depth());
    uniform[2] = if dag.is_empty() { 0 } else { dag.root() as u32 };
    uniform
}
