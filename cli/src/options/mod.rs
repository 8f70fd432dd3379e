//! The flags that several commands share. Defaults stand in the help texts; a flag that was not given stays `None` where
//! its absence matters. Here: how scenes are built, on what machine, and how results are printed.

mod picture;
pub mod values;

pub use picture::{ArithmeticArg, CameraArgs, LightArg, LightingArgs, NormalsArg, PictureArgs, SupersampleArg};
pub use values::{duration, error, frames, picture_size, resolution, supersample};

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use voxdag::colors::ColorMode;

use crate::error::{Error, Kind};
use crate::memory::Memory;
use crate::report::number as number_text;
use values::{memory_size, positive, threads, triple};

/// How the mesh becomes voxels.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Building")]
pub struct BuildArgs {
    /// Voxels along the longest axis, 1 to 2097152 [default: 512]
    #[arg(short, long, value_name = "N", value_parser = resolution, allow_negative_numbers = true)]
    pub resolution: Option<u32>,

    /// Side of a voxel in the mesh's units, instead of a resolution
    #[arg(long, value_name = "S", value_parser = positive, allow_hyphen_values = true)]
    pub voxel_size: Option<f64>,

    /// World position of the corner of voxel (0, 0, 0) [default: the minimum of the mesh's box]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub origin: Option<[f64; 3]>,

    /// Which voxels a triangle fills [default: exact]
    #[arg(long, value_name = "COVER", value_enum)]
    pub cover: Option<CoverArg>,

    /// How the filled voxels are laid out [default: dag]
    #[arg(long, value_name = "KIND", value_enum)]
    pub geometry: Option<GeometryArg>,

    /// What is kept of the surfaces [default: tree]
    #[arg(long, value_name = "KIND", value_enum)]
    pub materials: Option<MaterialsArg>,

    /// How the colours of textures (map_Kd) are kept, one a voxel [default: blocks]
    #[arg(long, value_name = "KIND", value_enum)]
    pub textures: Option<TexturesArg>,

    /// The axis that points up; kept in the file for `render` [default: y]
    #[arg(long, value_name = "AXIS", value_enum)]
    pub up_axis: Option<UpAxisArg>,
}

impl BuildArgs {
    /// Refuses flags that contradict each other.
    pub fn check(&self) -> Result<(), Error> {
        if self.resolution.is_some() && self.voxel_size.is_some() && self.origin.is_none() {
            return Err(Error::usage("--resolution and --voxel-size together leave open where the grid lies")
                .hint("give one of the two, or add --origin X,Y,Z"));
        }
        Ok(())
    }

    /// Refuses what no file holds.
    pub fn must_be_for_files(&self) -> Result<(), Error> {
        let refused = |flag: &str, kinds: &str| {
            Err(Error::usage(format_args!("{flag}: that is built in memory only, for `render` and `bench`"))
                .hint(format_args!("a file takes {kinds}")))
        };
        if self.geometry.is_some_and(|geometry| !geometry.is_for_files()) {
            return refused("--geometry", "dag or ssvdag");
        }
        if self.materials.is_some_and(|materials| !materials.is_for_files()) {
            return refused("--materials", "tree, table, table-normals, ranked or none");
        }
        Ok(())
    }

    /// Refuses flags of building for a scene that was built before.
    pub fn must_be_absent(&self, scene: &Path) -> Result<(), Error> {
        match self.given() {
            Some(flag) => Err(Error::usage(format_args!("{flag}: {} is built already", scene.display()))
                .hint("leave the flag away, or name the mesh instead of the scene")),
            None => Ok(()),
        }
    }

    /// Whether the pictures that materials name are read.
    pub fn reads_textures(&self) -> bool {
        self.textures.unwrap_or_default() != TexturesArg::None && self.materials != Some(MaterialsArg::None)
    }

    /// The first of these flags that was given, as it is typed.
    fn given(&self) -> Option<&'static str> {
        let flags = [
            (self.resolution.is_some(), "--resolution"),
            (self.voxel_size.is_some(), "--voxel-size"),
            (self.origin.is_some(), "--origin"),
            (self.cover.is_some(), "--cover"),
            (self.geometry.is_some(), "--geometry"),
            (self.materials.is_some(), "--materials"),
            (self.textures.is_some(), "--textures"),
            (self.up_axis.is_some(), "--up-axis"),
        ];
        flags.into_iter().find_map(|(given, flag)| given.then_some(flag))
    }

    /// The flags that were given, as they can be typed again after other words for `build`, which makes files.
    pub fn typed(&self) -> String {
        let flags = [
            self.resolution.map(|n| format!(" -r {n}")),
            self.voxel_size.map(|s| format!(" --voxel-size {}", number_text(s))),
            self.origin.map(|[x, y, z]| format!(" --origin {},{},{}", number_text(x), number_text(y), number_text(z))),
            self.cover.map(|cover| format!(" --cover {}", name_of(cover))),
            self.geometry.filter(|geometry| geometry.is_for_files()).map(|g| format!(" --geometry {}", name_of(g))),
            self.materials
                .filter(|materials| materials.is_for_files())
                .map(|materials| format!(" --materials {}", name_of(materials))),
            self.textures.map(|textures| format!(" --textures {}", name_of(textures))),
            self.up_axis.map(|axis| format!(" --up-axis {}", name_of(axis))),
        ];
        flags.into_iter().flatten().collect()
    }
}

/// How a choice is typed.
pub fn name_of<T: ValueEnum>(value: T) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

/// Which voxels a triangle fills.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum CoverArg {
    /// Every voxel that the triangle meets: no gap
    #[default]
    Exact,
    /// Fewer: a thin sheet (6-separating) whose edges let some rays through
    Thin,
    /// A little more, so that it also covers the vertices before they are snapped to the grid
    Inflated,
}

/// What is kept of the surfaces.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum MaterialsArg {
    /// A tree over space: the smallest and the fastest
    #[default]
    Tree,
    /// A table from voxel to material
    Table,
    /// A table from voxel to material and normal
    TableNormals,
    /// Packed numbers in the order of the voxels, found by rank
    Ranked,
    /// The same in blocks with palettes of their own; in memory only
    Palette,
    /// Williams's moxel table; in memory only
    Moxel,
    /// Williams's moxel table with normals; in memory only
    MoxelNormals,
    /// Shape only
    None,
}

impl MaterialsArg {
    /// Whether a file can hold it.
    fn is_for_files(self) -> bool {
        !matches!(self, MaterialsArg::Palette | MaterialsArg::Moxel | MaterialsArg::MoxelNormals)
    }
}

impl GeometryArg {
    /// Whether a file can hold it.
    fn is_for_files(self) -> bool {
        matches!(self, GeometryArg::Dag | GeometryArg::Ssvdag)
    }
}

/// How the colours of textures are kept.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum TexturesArg {
    /// Blocks of 64 voxels between two colours each: 5 bits a voxel at most where they fit, 39 dB or better
    #[default]
    Blocks,
    /// 24 bits a voxel: the very same colours
    Raw,
    /// Not at all: surfaces have their Kd
    None,
}

impl TexturesArg {
    /// In the core's words; `None` if not at all.
    pub fn mode(self) -> Option<ColorMode> {
        match self {
            TexturesArg::Blocks => Some(ColorMode::Blocks),
            TexturesArg::Raw => Some(ColorMode::Raw),
            TexturesArg::None => None,
        }
    }
}

/// How the filled voxels are laid out.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum GeometryArg {
    /// The sparse voxel DAG: the fastest
    #[default]
    Dag,
    /// Merged up to mirrors, too, and packed: about 0.4 of the bytes, rays take 1.1 of the time
    Ssvdag,
    /// The octree without sharing; in memory only
    Svo,
    /// The DAG with offsets in its pointers; in memory only
    Offsets,
    /// Williams's moxel DAG; in memory only
    Moxel,
}

/// The axis that points up.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum UpAxisArg {
    /// As most modelling programs write OBJ
    #[default]
    Y,
    /// As CAD, GIS and Blender's own axes
    Z,
}

/// What the machine may give.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Machine")]
pub struct MachineArgs {
    /// Threads to work with [default: all cores]
    #[arg(long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub threads: Option<u16>,

    /// Most memory to take, such as 512M, 4G or 1.5GiB; a run that needs more stops before it takes it
    ///
    /// Counted are, as far as they are held together: the files that are read; about what parsing a mesh takes; the
    /// mesh; what building takes (sorted triangles, owners of voxels, DAG, other layouts, materials); the scene; and
    /// the picture (8 bytes a pixel). What only makes rays faster takes of the rest what it can use. The program
    /// itself is not counted: a few MiB.
    #[arg(long, value_name = "SIZE", verbatim_doc_comment, value_parser = memory_size, allow_hyphen_values = true)]
    pub memory_limit: Option<u64>,
}

impl MachineArgs {
    /// The account of `--memory-limit`.
    pub fn memory(&self) -> Memory {
        Memory::new(self.memory_limit)
    }

    /// The threads that the run works on.
    pub fn pool(&self) -> Result<rayon::ThreadPool, Error> {
        rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0).into())
            .build()
            .map_err(|cause| Error::new(Kind::Failure, cause).hint("try fewer --threads"))
    }
}

/// From where a scene is seen, and its light, from a file.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Picture")]
pub struct ViewArgs {
    /// Camera, lights, background and a camera path from a file, see docs/view.md; flags win over it
    #[arg(long, value_name = "VIEW.toml")]
    pub view: Option<PathBuf>,
}

/// How the result is printed.
#[derive(Args, Clone, Copy, Debug, Default)]
pub struct ReportArgs {
    /// Print the result as JSON to stdout
    #[arg(long)]
    pub json: bool,
}
