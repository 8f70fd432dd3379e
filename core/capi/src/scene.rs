//! Scenes: a file's words, checked once, and what is derived from them to make rays fast.

use core::ffi::c_char;
use core::mem::MaybeUninit;

use voxdag::file::{self, Scene};
use voxdag::grid::UpAxis;
use voxdag::layout::AnyGeometry;
use voxdag::material::{Material, MaterialId};
use voxdag::simd::Level;
use voxdag::trace::Tracer;
use voxdag::trees::{Trees, tracer};
use voxdag::wide::Wide;
use voxdag::{Dag, Geometry, Grid};

use crate::border::{Caller, Kept, forever};
use crate::error::{Failure, VoxdagError, VoxdagStatus};

/// A scene that was opened. It never changes: any number of threads may use it at the same time.
pub struct VoxdagScene {
    // What is borrowed from comes last, so that it outlives what borrows it.
    pub(crate) tracer: AnyTracer,
    pub(crate) scene: Scene<'static>,
    pub(crate) palette: Vec<Material>,
    words: usize,
    trees: Kept<Trees>,
    _owned: Vec<u32>,
}

/// What answers rays of a scene: its wide tree, its DAG, or whatever else it has, which is asked for its layout at every
/// step. Made once, as a top grid is checked as a whole.
pub(crate) enum AnyTracer {
    Wide(Tracer<'static, Wide<'static>>),
    Dag(Tracer<'static, Dag<'static>>),
    Other(Tracer<'static, AnyGeometry<'static>>),
}

/// Runs the same expression with what answers rays of a scene. Three copies of each kernel are compiled, not one for each
/// layout there is.
macro_rules! with_tracer {
    ($scene:expr, $tracer:ident => $body:expr) => {
        match $scene.tracer {
            $crate::scene::AnyTracer::Wide($tracer) => $body,
            $crate::scene::AnyTracer::Dag($tracer) => $body,
            $crate::scene::AnyTracer::Other($tracer) => $body,
        }
    };
}
pub(crate) use with_tracer;

/// Threads may share a scene.
const _: fn() = || {
    fn shared<T: Send + Sync>() {}
    shared::<VoxdagScene>();
};

/// Which axis of the world points up.
#[repr(u32)]
pub enum VoxdagUp {
    /// +y is up, +z towards the viewer.
    Y = 0,
    /// +z is up, -y towards the viewer.
    Z = 1,
}

/// What a scene is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct VoxdagSceneInfo {
    /// Voxels along the longest axis, 1 to 2^21.
    pub resolution: u32,
    /// Octree levels: the smallest L with 2^L >= resolution.
    pub depth: u32,
    /// Number of materials, 1 to 65,536.
    pub material_count: u32,
    /// `VOXDAG_UP_*`.
    pub up: u32,
    /// Whether voxels have normals of their own (1) or not (0): `VOXDAG_NORMALS_STORED`.
    pub has_normals: u32,
    /// Whether voxels have colours (1) or not (0): `voxdag_colors`.
    pub has_colors: u32,
    /// Filled voxels.
    pub voxel_count: u64,
    /// Words of the file.
    pub word_count: u64,
    /// Bytes of the heap that the trees take.
    pub tree_bytes: u64,
    /// World position of the corner of voxel (0, 0, 0): world = origin + voxel_size * grid, for each axis.
    pub origin: [f64; 3],
    /// Side of a voxel in world units.
    pub voxel_size: f64,
    /// The mesh's box in world units: smallest coordinates,
    pub bounds_min: [f64; 3],
    /// and largest ones.
    pub bounds_max: [f64; 3],
    /// Metres per world unit; 0 if nobody said.
    pub metres_per_unit: f64,
}

/// What a surface looks like. Colours are linear light, red, green, blue; every number is finite and 0 or more.
#[repr(C)]
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct VoxdagMaterial {
    /// Ka: share of the ambient light that comes back.
    pub ambient: [f32; 3],
    /// Kd: matte reflection.
    pub diffuse: [f32; 3],
    /// Ks: highlight, mirror.
    pub specular: [f32; 3],
    /// Ke: own light.
    pub emission: [f32; 3],
    /// Tf: light let through.
    pub transmission: [f32; 3],
    /// d: 1 is solid, 0 is invisible.
    pub opacity: f32,
    /// Ni: optical density.
    pub refraction: f32,
    /// Ns: the highlight's exponent, 1 to 1,000,000; others are moved into that range.
    pub shininess: u32,
    /// illum: the illumination model of MTL files, 0 to 10.
    pub illum: u32,
    /// Whether voxels have colours that it is multiplied by (1) or not (0). `voxdag_build` does not read
    /// it: it takes textures.
    pub textured: u32,
}

impl VoxdagScene {
    /// `words` are kept by the caller, or are those of `owned`.
    fn new(words: &'static [u32], owned: Vec<u32>, tree_bytes: u64) -> Result<VoxdagScene, Failure> {
        let scene = file::read(words)?;
        let count = scene.material_count();
        let mut palette = Vec::new();
        palette
            .try_reserve_exact(count)
            .map_err(|_| Failure::Memory { needed: (count * size_of::<Material>()) as u64 })?;
        palette.extend((0..count).map(|id| scene.material(id as MaterialId)));
        let trees = Kept::new(Trees::new(scene.geometry, (tree_bytes != u64::MAX).then_some(tree_bytes)))?;
        // SAFETY: the scene keeps them, where they are and as they are, as long as itself.
        let derived = unsafe { forever(trees.get()) };
        let (top, level) = (derived.top.as_ref(), Level::best());
        let tracer = match (&derived.wide, scene.geometry) {
            (Some(wide), _) => AnyTracer::Wide(tracer(wide.as_wide(), top).with_level(level)),
            (None, AnyGeometry::Dag(dag)) => AnyTracer::Dag(tracer(dag, top).with_level(level)),
            (None, geometry) => AnyTracer::Other(tracer(geometry, top).with_level(level)),
        };
        Ok(VoxdagScene { tracer, scene, palette, words: words.len(), trees, _owned: owned })
    }

    fn info(&self) -> Result<VoxdagSceneInfo, Failure> {
        let Scene { grid: Grid { origin, voxel_size, resolution }, bounds, metres_per_unit, .. } = self.scene;
        let stats = self.scene.geometry.stats().map_err(|bytes| Failure::Memory { needed: bytes as u64 })?;
        Ok(VoxdagSceneInfo {
            resolution,
            depth: self.scene.geometry.depth().into(),
            material_count: self.palette.len() as u32,
            up: match self.scene.up {
                UpAxis::Y => VoxdagUp::Y,
                UpAxis::Z => VoxdagUp::Z,
            } as u32,
            has_normals: self.scene.materials.has_normals().into(),
            has_colors: self.scene.colors.is_some().into(),
            voxel_count: stats.voxels,
            word_count: self.words as u64,
            tree_bytes: self.trees.get().bytes(),
            origin,
            voxel_size,
            bounds_min: bounds.min,
            bounds_max: bounds.max,
            metres_per_unit,
        })
    }
}

impl From<&Material> for VoxdagMaterial {
    fn from(material: &Material) -> VoxdagMaterial {
        let Material {
            ambient,
            diffuse,
            specular,
            emission,
            transmission,
            shininess,
            opacity,
            refraction,
            illum,
            textured,
        } = *material;
        VoxdagMaterial {
            ambient,
            diffuse,
            specular,
            emission,
            transmission,
            opacity,
            refraction,
            shininess,
            illum: illum.into(),
            textured: textured.into(),
        }
    }
}

/// Opens a scene: checks the words of a .vxd file, all of them, and makes trees over them. The words are neither copied nor
/// changed; they must stay as and where they are until the scene is closed. O(words).
///
/// A word is 4 bytes of the file, low byte first: on a machine that stores the low byte first, a file read into memory
/// that is aligned to 4 bytes.
///
/// tree_bytes: most bytes of the heap that the trees may take. They make rays some times faster and change no answer. 0:
/// none, for little memory or a few rays; UINT64_MAX: no limit. What does not fit is left out.
/// scene: where the handle goes; nothing is written if the scene is refused. Close it with `voxdag_scene_close`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_scene_open(
    words: *const u32,
    word_count: usize,
    tree_bytes: u64,
    scene: *mut *mut VoxdagScene,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for, of the words until the scene is closed.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let words = caller.kept("words", words, word_count)?;
        caller.room("scene", scene, 1)?;
        caller.give("scene", scene, VoxdagScene::new(words, Vec::new(), tree_bytes)?)
    })
}

/// The same from bytes of any alignment, on any machine: they are copied, and may be freed after the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_scene_open_bytes(
    bytes: *const u8,
    byte_count: usize,
    tree_bytes: u64,
    scene: *mut *mut VoxdagScene,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let owned = file::words_from_bytes(caller.slice("bytes", bytes, byte_count)?)?;
        caller.room("scene", scene, 1)?;
        // SAFETY: the scene keeps the list, unchanged, as long as itself.
        let words = unsafe { forever(&owned[..]) };
        caller.give("scene", scene, VoxdagScene::new(words, owned, tree_bytes)?)
    })
}

/// Closes a scene, which must not be used any more, by no thread. Null is nothing.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_scene_close(scene: *mut VoxdagScene) {
    // SAFETY: what the header asks for: opened, closed once, not in use.
    let caller = unsafe { Caller::new() };
    caller.run(core::ptr::null_mut(), || {
        caller.take(scene);
        Ok(())
    });
}

/// What a scene is. Counts voxels: O(words), with memory from the heap.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_scene_info(
    scene: *const VoxdagScene,
    info: *mut VoxdagSceneInfo,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || caller.put("info", info, caller.one("scene", scene)?.info()?))
}

/// The parameters of a material, 0 to `material_count - 1`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_scene_material(
    scene: *const VoxdagScene,
    id: u32,
    material: *mut VoxdagMaterial,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let found = caller.one("scene", scene)?.palette.get(id as usize);
        caller.put("material", material, found.ok_or(Failure::Choice { name: "material", found: id })?.into())
    })
}

/// The name of a material, UTF-8 with a zero byte after it, in `room` bytes of `name`. If they are too few, what is needed,
/// the zero byte included, is in `error->needed`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_scene_material_name(
    scene: *const VoxdagScene,
    id: u32,
    name: *mut c_char,
    room: usize,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        if scene.palette.get(id as usize).is_none() {
            return Err(Failure::Choice { name: "material", found: id });
        }
        let name = caller.room("name", name.cast::<u8>(), room)?;
        let bytes = || scene.scene.name(id as MaterialId).bytes().chain([0]);
        if bytes().count() > name.len() {
            return Err(Failure::TooSmall { needed: bytes().count() as u64, unit: "bytes" });
        }
        name.iter_mut().zip(bytes()).for_each(|(place, byte)| *place = MaybeUninit::new(byte));
        Ok(())
    })
}

/// The material that stands in where a mesh names none: grey, matte.
#[unsafe(no_mangle)]
pub extern "C" fn voxdag_material_default() -> VoxdagMaterial {
    (&Material::GREY).into()
}
