//! Borrowed triangles: what voxelisation reads.
//!
//! In: slices that the caller owns. Out: a view whose indices and numbers were checked once by [`Mesh::validate`].

use crate::grid::Bounds;

/// Triangles over shared vertices, one material each.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mesh<'a> {
    /// World positions, one per vertex; those that no triangle uses are ignored.
    pub positions: &'a [[f64; 3]],
    /// Three indices into `positions` each, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// Material id per triangle; empty means 0 for all.
    pub materials: &'a [u16],
    /// Place of each material id among the sorted names, for ties between triangles; empty means the id itself.
    pub name_order: &'a [u16],
    /// Texture coordinates per triangle and corner, NaN where the file gave none; empty means none at all. (0, 0) is the lower
    /// left corner of the picture, v goes up. Read where pictures are given:
    /// [`Build::with_textures`](crate::scene::Build::with_textures).
    pub uvs: &'a [[[f32; 2]; 3]],
    /// Normals per triangle and corner, NaN where the file gave none; empty means none at all.
    pub normals: &'a [[[f32; 3]; 3]],
}

/// What is wrong with a mesh, and where (all indices count from 0).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum MeshError {
    /// No triangle.
    Empty,
    /// More than 2^31 triangles or 2^32 vertices.
    TooLarge,
    /// A coordinate of a vertex in use is NaN or infinite.
    NonFinite {
        /// Index into `positions`.
        vertex: u32,
    },
    /// A triangle names a vertex that does not exist.
    VertexIndex {
        /// Index into `triangles`.
        triangle: u32,
        /// The index it holds.
        vertex: u32,
    },
    /// A per-triangle slice is neither empty nor as long as `triangles`.
    Length {
        /// Name of the field of [`Mesh`].
        field: &'static str,
        /// Its length.
        found: usize,
    },
    /// A triangle's material has no place in `name_order`.
    MaterialIndex {
        /// Index into `triangles`.
        triangle: u32,
    },
}

impl core::fmt::Display for MeshError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            MeshError::Empty => write!(f, "the mesh has no triangles"),
            MeshError::TooLarge => write!(f, "the mesh has more than 2^31 triangles or 2^32 vertices"),
            MeshError::NonFinite { vertex } => {
                write!(f, "vertex {vertex} (counted from 0) has a coordinate that is not finite")
            }
            MeshError::VertexIndex { triangle, vertex } => {
                write!(f, "triangle {triangle} names vertex {vertex}, which does not exist (both counted from 0)")
            }
            MeshError::Length { field, found } => {
                write!(f, "`{field}` has {found} entries: expected none or one per triangle")
            }
            MeshError::MaterialIndex { triangle } => {
                write!(f, "the material of triangle {triangle} (counted from 0) has no place in `name_order`")
            }
        }
    }
}

impl core::error::Error for MeshError {}

impl Mesh<'_> {
    /// Checks every index and every number, and gives the box of the vertices that triangles use. O(triangles).
    pub fn validate(&self) -> Result<Bounds, MeshError> {
        if self.triangles.is_empty() {
            return Err(MeshError::Empty);
        }
        if self.triangles.len() >> 31 != 0 || self.positions.len() as u64 > 1 << 32 {
            return Err(MeshError::TooLarge);
        }
        let lengths = [("materials", self.materials.len()), ("uvs", self.uvs.len()), ("normals", self.normals.len())];
        for (field, found) in lengths {
            if found != 0 && found != self.triangles.len() {
                return Err(MeshError::Length { field, found });
            }
        }
        let mut bounds = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for &vertex in corners {
                let Some(p) = self.positions.get(vertex as usize) else {
                    return Err(MeshError::VertexIndex { triangle: triangle as u32, vertex });
                };
                for i in 0..3 {
                    if !p[i].is_finite() {
                        return Err(MeshError::NonFinite { vertex });
                    }
                    // Of the two zeros always the positive one: which of them `min` gives is up to the target.
                    let x = p[i] + 0.0;
                    bounds.min[i] = bounds.min[i].min(x);
                    bounds.max[i] = bounds.max[i].max(x);
                }
            }
            if !self.name_order.is_empty() && usize::from(self.material(triangle)) >= self.name_order.len() {
                return Err(MeshError::MaterialIndex { triangle: triangle as u32 });
            }
        }
        Ok(bounds)
    }

    /// Material id of a triangle; 0 where the mesh has no list.
    #[inline]
    pub fn material(&self, triangle: usize) -> u16 {
        self.materials.get(triangle).copied().unwrap_or(0)
    }
}
