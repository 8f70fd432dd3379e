//! From triangles to the words of a .vxd file.

use core::ffi::c_char;

use voxdag::colors::ColorMode;
use voxdag::file::Parts;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::layout::AnyGeometry;
use voxdag::material::Material;
use voxdag::scene::{Build, MaterialMode, Options};
use voxdag::voxelize::Cover;
use voxdag::{Grid, Mesh};

use crate::border::Caller;
use crate::error::{Failure, VoxdagError, VoxdagStatus};
use crate::pictures::Pictures;
use crate::scene::VoxdagMaterial;

/// Triangles over shared vertices.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VoxdagMesh {
    /// Number of vertices, below 2^32.
    pub vertex_count: usize,
    /// Number of triangles, 1 to 2^31 - 1.
    pub triangle_count: usize,
    /// 3 * vertex_count numbers: x, y, z of each in world units.
    pub positions: *const f64,
    /// 3 * triangle_count numbers: the vertices of each, counter-clockwise as seen from outside.
    pub indices: *const u32,
    /// The material of each triangle, triangle_count numbers; null: 0 for all.
    pub triangle_materials: *const u16,
    /// Number of materials, at most 65,536; 0: one, `voxdag_material_default()`.
    pub material_count: usize,
    /// The materials.
    pub materials: *const VoxdagMaterial,
    /// Their names, material_count texts in UTF-8 that end with a zero byte; null: none, and each of them may be.
    pub names: *const *const c_char,
    /// Texture coordinates, 6 * triangle_count numbers: u, v at each of a triangle's corners; (0, 0) is the lower left corner
    /// of a picture, v goes up. Null: none, and textures are not used. Triangles with one that is not finite are white.
    pub uvs: *const f32,
    /// What colours the voxels of each material, in place of map_Kd: material_count textures; null: none. The colours multiply
    /// `ambient` and `diffuse`.
    pub textures: *const VoxdagTexture,
    /// What cuts each material out, in place of map_d: material_count textures; null: none. A triangle fills a voxel only if
    /// the picture leaves half or more of it: by its opacity, or, of an opaque picture, by its brightness.
    pub cutouts: *const VoxdagTexture,
}

/// A picture as it lies on surfaces; it is read during the call only. Begin with `voxdag_texture_default()`, which is none.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagTexture {
    /// 4 * width * height bytes, row by row from the top: red, green, blue in sRGB, and opacity (255 opaque). Null: no
    /// texture. Textures with the same pixels, width and height share one picture.
    pub pixels: *const u8,
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Factors on u and v.
    pub scale: [f32; 2],
    /// What is added to the scaled u and v.
    pub offset: [f32; 2],
    /// What is added to the picture's values.
    pub base: f32,
    /// Factor on the picture's values.
    pub gain: f32,
    /// Whether the picture ends in its borders outside 0 to 1 (1) or is repeated (0).
    pub clamp: u32,
}

/// No texture. Once it has pixels: the picture as it is, once per unit of u and v, again and again.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_texture_default() -> VoxdagTexture {
    VoxdagTexture {
        pixels: core::ptr::null(),
        width: 0,
        height: 0,
        scale: [1.0; 2],
        offset: [0.0; 2],
        base: 0.0,
        gain: 1.0,
        clamp: 0,
    }
}

/// Which voxels a triangle fills.
#[repr(u32)]
pub enum VoxdagCover {
    /// Those that it meets: rays cannot pass (the default).
    Exact = 0,
    /// Those whose centre cross it pierces: thinner, rays may slip through edges.
    Thin = 1,
    /// Those that it comes within 1/512 of a voxel of.
    Inflated = 2,
}

/// How materials are kept.
#[repr(u32)]
pub enum VoxdagKeep {
    /// A tree over space; the smallest and the fastest (the default).
    Tree = 0,
    /// A hash table without normals.
    Table = 1,
    /// A hash table with the normals of the triangles: `VOXDAG_NORMALS_STORED`.
    TableNormals = 2,
    /// Not at all: every voxel has material 0.
    None = 3,
}

/// How the colours of textures are kept.
#[repr(u32)]
pub enum VoxdagColors {
    /// Blocks of 64 voxels between two colours each: some 5 bits a voxel, nearly the same colours (the default).
    Blocks = 0,
    /// 24 bits a voxel, the very same colours.
    Raw = 1,
}

/// What to build. Begin with `voxdag_build_default()`.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagBuild {
    /// Voxels along the longest axis, 1 to 2^21.
    pub resolution: u32,
    /// `VOXDAG_COVER_*`.
    pub cover: u32,
    /// `VOXDAG_KEEP_*`; with `VOXDAG_KEEP_NONE` textures are left out, too.
    pub keep: u32,
    /// `VOXDAG_COLORS_*`.
    pub colors: u32,
    /// `VOXDAG_UP_*`, for the default view.
    pub up: u32,
    /// Side of a voxel in world units, for a grid of the caller's choice that holds the whole mesh; 0: the smallest grid
    /// of `resolution` voxels around the mesh.
    pub voxel_size: f64,
    /// World position of the corner of voxel (0, 0, 0) of such a grid.
    pub origin: [f64; 3],
    /// Metres per world unit, for the file; 0 if nobody knows.
    pub metres_per_unit: f64,
    /// Most bytes of the heap that building may take, about; UINT64_MAX for no limit.
    pub memory_limit: u64,
}

/// 512 voxels along the longest axis of the smallest grid around the mesh, exact cover, a tree of materials, y up, no limit.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_build_default() -> VoxdagBuild {
    VoxdagBuild {
        resolution: 512,
        cover: VoxdagCover::Exact as u32,
        keep: VoxdagKeep::Tree as u32,
        colors: VoxdagColors::Blocks as u32,
        up: crate::VoxdagUp::Y as u32,
        voxel_size: 0.0,
        origin: [0.0; 3],
        metres_per_unit: 0.0,
        memory_limit: u64::MAX,
    }
}

/// Builds a scene from triangles: the words of a .vxd file, for `voxdag_scene_open` or, low byte first, for a file. The same
/// mesh gives the same words on every machine. What is worked with comes from the heap and is given back.
///
/// words: room for `room` words. If they are too few, the status is `VOXDAG_STATUS_TOO_SMALL`, and nothing is written to
/// them; null and 0 only ask. Asking takes as long as building, so lend generously, or keep what does not change.
/// word_count: how many words the file has; also written if the room is too small.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_build(
    mesh: *const VoxdagMesh,
    build: *const VoxdagBuild,
    words: *mut u32,
    room: usize,
    word_count: *mut usize,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let mesh = caller.one("mesh", mesh)?;
        let options = caller.one("build", build)?;
        caller.room("words", words, room)?;
        caller.room("word_count", word_count, 1)?;

        // The mesh, its materials, their names and pictures.
        let triangle_materials =
            caller.optional("mesh.triangle_materials", mesh.triangle_materials, mesh.triangle_count)?;
        let uvs = caller.optional("mesh.uvs", mesh.uvs.cast::<[[f32; 2]; 3]>(), mesh.triangle_count)?;
        let view = Mesh {
            positions: caller.triples("mesh.positions", mesh.positions, mesh.vertex_count)?,
            triangles: caller.triples("mesh.indices", mesh.indices, mesh.triangle_count)?,
            materials: triangle_materials.unwrap_or(&[]),
            uvs: uvs.unwrap_or(&[]),
            ..Mesh::default()
        };
        let (mut materials, names) = looks(&caller, mesh)?;
        let count = materials.len() as u64;
        let missing = |id: &u16| u64::from(*id) >= count;
        if let Some(triangle) = view.materials.iter().position(missing) {
            let material = view.materials[triangle];
            return Err(Failure::TriangleMaterial { triangle: triangle as u64, material, count });
        }
        let mut pictures = Pictures::new(options.memory_limit);
        let maps = if uvs.is_some() { pictures.maps(&caller, mesh)? } else { Vec::new() };

        // The voxels.
        let bounds = view.validate()?;
        let grid = options.grid(&bounds)?;
        let built = Build::new(&view, &grid, &options.options(pictures.bytes)?)
            .and_then(|build| build.with_textures(&maps).run())
            .map_err(|error| pictures.beside(error))?;
        let looks = built.looks().map_err(|_| Failure::Panic)?;
        for (material, maps) in materials.iter_mut().zip(&maps) {
            material.textured = looks.colors.is_some() && maps.diffuse().is_some();
        }

        // The file.
        let parts = Parts {
            grid: grid.checked()?,
            bounds,
            up: options.up()?,
            metres_per_unit: options.metres_per_unit,
            geometry: AnyGeometry::Dag(built.dag.dag()),
            voxel_materials: looks.materials,
            colors: looks.colors,
            materials: &materials,
            names: &names,
        };
        let needed = parts.file_len();
        caller.put("word_count", word_count, usize::try_from(needed).unwrap_or(usize::MAX))?;
        if (room as u64) < needed {
            return Err(Failure::TooSmall { needed, unit: "words" });
        }
        parts.write_into(caller.cleared("words", words, needed as usize)?)?;
        Ok(())
    })
}

/// A list with room for `count` items, or what it would take.
pub(crate) fn list<T>(count: usize) -> Result<Vec<T>, Failure> {
    let mut list = Vec::new();
    let needed = (count as u64).saturating_mul(size_of::<T>() as u64);
    list.try_reserve_exact(count).map_err(|_| Failure::Memory { needed })?;
    Ok(list)
}

/// The materials and their names, as many of both.
fn looks<'a>(caller: &'a Caller, mesh: &VoxdagMesh) -> Result<(Vec<Material>, Vec<&'a str>), Failure> {
    let given = caller.slice("mesh.materials", mesh.materials, mesh.material_count)?;
    if given.len() > 1 << 16 {
        return Err(Failure::Count { name: "mesh.materials", found: given.len() as u64 });
    }
    let texts = caller.optional("mesh.names", mesh.names, given.len())?;
    let (mut materials, mut names) = (list(given.len().max(1))?, list(given.len().max(1))?);
    for (i, material) in given.iter().enumerate() {
        materials.push(material.checked(i as u64)?);
        let text = texts.map_or(c"", |texts| caller.text(texts[i]));
        names.push(text.to_str().map_err(|_| Failure::Name { index: i as u64 })?);
    }
    if given.is_empty() {
        materials.push(Material::GREY);
        names.push("");
    }
    Ok((materials, names))
}

impl VoxdagMaterial {
    fn checked(&self, index: u64) -> Result<Material, Failure> {
        let VoxdagMaterial {
            ambient,
            diffuse,
            specular,
            emission,
            transmission,
            opacity,
            refraction,
            shininess,
            illum,
            textured: _,
        } = *self;
        if illum > 10 {
            return Err(Failure::Illum { index, found: illum });
        }
        let material = Material {
            ambient,
            diffuse,
            specular,
            emission,
            transmission,
            shininess,
            opacity,
            refraction,
            illum: illum as u8,
            textured: false,
        };
        material.checked().map_err(|error| Failure::Material { index, error })
    }
}

impl VoxdagBuild {
    fn grid(&self, bounds: &Bounds) -> Result<Grid, Failure> {
        let VoxdagBuild { resolution, voxel_size, origin, .. } = *self;
        Ok(if voxel_size == 0.0 {
            Grid::fit(bounds, resolution)?
        } else {
            Grid { origin, voxel_size, resolution }.checked()?
        })
    }

    fn up(&self) -> Result<UpAxis, Failure> {
        match self.up {
            0 => Ok(UpAxis::Y),
            1 => Ok(UpAxis::Z),
            found => Err(Failure::Choice { name: "up axis", found }),
        }
    }

    /// With so many bytes of the limit taken already.
    fn options(&self, taken: u64) -> Result<Options, Failure> {
        self.up()?;
        if !(self.metres_per_unit >= 0.0 && self.metres_per_unit.is_finite()) {
            return Err(Failure::NotFinite { name: "metres_per_unit" });
        }
        let cover = [Cover::Exact, Cover::Thin, Cover::Inflated];
        let keep = [MaterialMode::Tree, MaterialMode::Table, MaterialMode::TableNormals, MaterialMode::None];
        let colors = [ColorMode::Blocks, ColorMode::Raw];
        let choice = |name, found| Failure::Choice { name, found };
        Ok(Options {
            cover: *cover.get(self.cover as usize).ok_or(choice("cover", self.cover))?,
            materials: *keep.get(self.keep as usize).ok_or(choice("way to keep materials", self.keep))?,
            colors: *colors.get(self.colors as usize).ok_or(choice("way to keep colours", self.colors))?,
            memory_limit: (self.memory_limit != u64::MAX).then_some(self.memory_limit.saturating_sub(taken)),
            parts_at_once: 1,
        })
    }
}
