//! A scene at a level of detail, as `--lod` asks for it.

use voxdag::build::{BuildError, DagBuf};
use voxdag::colors::Painted;
use voxdag::geometry::Geometry;
use voxdag::layout::AnyGeometry;
use voxdag::lod::Lod;
use voxdag::match_geometry;
use voxdag::material::MaterialId;
use voxdag::materials::{AnyMaterials, Materials};
use voxdag::{Grid, Morton};

use crate::error::{Error, Kind, Result};
use crate::memory::{Memory, round_up};
use crate::picture::Shown;

/// What is derived for it: nothing at level 0.
pub struct Detail(Option<Coarser>);

struct Coarser {
    level: u8,
    dag: DagBuf,
    grid: Grid,
}

impl Detail {
    /// Derives `level`, if the scene has it and the memory limit allows it.
    pub fn new(scene: &Shown<'_>, level: u8, memory: &Memory) -> Result<Detail> {
        if level == 0 {
            return Ok(Detail(None));
        }
        let depth = scene.geometry.depth();
        let lod = Lod::new(scene.geometry, level).ok_or_else(|| {
            Error::usage(format_args!("--lod {level}: the scene is a single voxel at level {depth} already"))
                .hint(format!("take 0 to {depth}"))
        })?;
        let grid = lod.grid(&scene.grid).map_err(|error| Error::usage(format_args!("--lod {level}: {error}")))?;
        // Lists that grow and sets beside them take up to four times what is built.
        let limit = memory.left().map_or(u32::MAX, |left| u32::try_from(left / 16).unwrap_or(u32::MAX));
        let built = match_geometry!(scene.geometry, g => Lod::new(g, level).map(|lod| lod.build(limit)));
        let dag = built.expect("there is such a level").map_err(|error| match error {
            BuildError::Words { needed } => {
                let hint = format!("set --memory-limit to at least {}", round_up(memory.held() + 16 * needed));
                let what = format!("the scene at --lod {level}");
                let refused = memory.afford(16 * needed, &what, &hint);
                refused.err().unwrap_or_else(|| Error::new(Kind::Limit, error))
            }
            error => Error::new(Kind::Failure, format_args!("--lod {level}: {error}")),
        })?;
        Ok(Detail(Some(Coarser { level, dag, grid })))
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> u64 {
        self.0.as_ref().map_or(0, |coarser| size_of_val(coarser.dag.words()) as u64)
    }

    /// The scene that it was derived from, at its level.
    pub fn of<'s>(&'s self, scene: &Shown<'s>) -> Shown<'s> {
        let Some(Coarser { level, dag, grid }) = &self.0 else { return scene.clone() };
        let lod = Lod::new(scene.geometry, *level);
        Shown { grid: *grid, geometry: AnyGeometry::Dag(dag.dag()), lod, ..scene.clone() }
    }
}

/// The materials and colours of a scene's voxels, by way of the finer ones where these are what has materials.
#[derive(Clone, Copy)]
pub struct Looks<'a> {
    pub fine: Painted<'a, AnyMaterials<'a>>,
    pub lod: Option<Lod<AnyGeometry<'a>>>,
}

impl Materials for Looks<'_> {
    #[inline]
    fn id(&self, voxel: Morton) -> MaterialId {
        match self.lod {
            None => self.fine.id(voxel),
            Some(lod) => lod.materials(self.fine).id(voxel),
        }
    }

    #[inline]
    fn normal(&self, voxel: Morton) -> Option<[f32; 3]> {
        match self.lod {
            None => self.fine.normal(voxel),
            Some(lod) => lod.materials(self.fine).normal(voxel),
        }
    }

    #[inline]
    fn color(&self, voxel: Morton) -> Option<[u8; 3]> {
        match self.lod {
            None => self.fine.color(voxel),
            Some(lod) => lod.materials(self.fine).color(voxel),
        }
    }
}
