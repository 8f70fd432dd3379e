//! What is where rays hit: normals, materials, colours.

use voxdag::Materials;
use voxdag::Morton;
use voxdag::normal::{Normal, NormalKind, normal, normals};
use voxdag::simd::Level;
use voxdag::trace::{Face, Hit};

use crate::VOXDAG_NONE;
use crate::border::Caller;
use crate::error::{Failure, VoxdagError, VoxdagStatus};
use crate::ray::{VoxdagHit, face, voxel};
use crate::scene::{VoxdagScene, with_tracer};

/// Where normals come from.
#[repr(u32)]
pub enum VoxdagNormals {
    /// The side of the voxel through which the ray came.
    Face = 0,
    /// As kept with the materials; PLANE2 where none is.
    Stored = 1,
    /// From the six neighbours: one of 26 directions.
    Gradient = 2,
    /// The plane through the 3^3 voxels around: about 6 degrees off on a curved surface.
    Plane1 = 3,
    /// The plane through the 5^3 voxels around: about 2 degrees off (the best choice for most).
    Plane2 = 4,
    /// The plane through the 7^3 voxels around: about 1 degree off, and wider corners.
    Plane3 = 5,
    /// The plane of Ernerfeldt through the 3^3 voxels around, to compare with.
    Ernerfeldt1 = 6,
    /// The plane of Ernerfeldt through the 5^3 voxels around, to compare with.
    Ernerfeldt2 = 7,
}

/// The surface's direction at a hit: a unit vector out of the surface, 3 numbers.
///
/// kind: `VOXDAG_NORMALS_*`. direction: 3 numbers, the ray's. Of the hit, `voxel` and `face` count; of a miss the normal is
/// 0, 0, 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_normal(
    scene: *const VoxdagScene,
    kind: u32,
    hit: *const VoxdagHit,
    direction: *const f64,
    normal: *mut f32,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        let kind = normal_kind(kind)?;
        let hit = caller.one("hit", hit)?;
        let direction = caller.triples("direction", direction, 1)?[0];
        let place = caller.room("normal", normal.cast::<[f32; 3]>(), 1)?;
        let found = match hit_at(hit.voxel, hit.face, 0)? {
            Some(hit) => with_tracer!(scene, tracer => {
                self::normal(&tracer, scene.scene.materials, &hit, direction, kind).direction
            }),
            None => [0.0; 3],
        };
        place[0].write(found);
        Ok(())
    })
}

/// The surface's directions at many hits, the same answers as one by one; fastest where hits that follow each other are
/// near each other. Takes up to 30 KiB of stack, no heap.
///
/// voxels, faces: `count` items, as `voxdag_trace_many` wrote them. directions: 3 * count numbers, those of the rays.
/// normals: room for 3 * count numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_normals(
    scene: *const VoxdagScene,
    kind: u32,
    count: usize,
    voxels: *const u64,
    faces: *const u8,
    directions: *const f64,
    normals: *mut f32,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let scene = caller.one("scene", scene)?;
        let kind = normal_kind(kind)?;
        let voxels = caller.slice("voxels", voxels, count)?;
        let faces = caller.slice("faces", faces, count)?;
        let directions = caller.triples("directions", directions, count)?;
        let places = caller.room("normals", normals.cast::<[f32; 3]>(), count)?;
        with_tracer!(scene, tracer => {
            // Only the hits among them go on, close together.
            let mut first = 0;
            while first < count {
                let end = count.min(first + CHUNK);
                let (mut hits, mut ways) = ([MISS; CHUNK], [[0.0; 3]; CHUNK]);
                let mut found = [NO_NORMAL; CHUNK];
                let mut used = 0;
                for at in first..end {
                    if let Some(hit) = hit_at(voxels[at], faces[at].into(), at as u64)? {
                        (hits[used], ways[used]) = (hit, directions[at]);
                        used += 1;
                    }
                }
                let (hits, ways) = (&hits[..used], &ways[..used]);
                self::normals(Level::best(), &tracer, scene.scene.materials, hits, ways, kind, &mut found);
                let mut found = found.iter();
                for at in first..end {
                    let normal = if voxels[at] == VOXDAG_NONE { None } else { found.next() };
                    places[at].write(normal.map_or([0.0; 3], |normal| normal.direction));
                }
                first = end;
            }
        });
        Ok(())
    })
}

/// The materials of `count` voxels, one or many: numbers for `voxdag_scene_material`. UINT32_MAX for `VOXDAG_NONE`; a voxel
/// that is not filled has some material.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_materials(
    scene: *const VoxdagScene,
    count: usize,
    voxels: *const u64,
    ids: *mut u32,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let materials = caller.one("scene", scene)?.scene.materials;
        let voxels = caller.slice("voxels", voxels, count)?;
        for (place, code) in caller.room("ids", ids, count)?.iter_mut().zip(voxels) {
            place.write(voxel(*code).map_or(u32::MAX, |voxel| materials.id(voxel).into()));
        }
        Ok(())
    })
}

/// The colours that textures gave to `count` voxels, one or many: 4 bytes each, red, green, blue in sRGB and 255; all 0
/// where there is none. A material that is `textured` is multiplied by the colour, once that is decoded to linear light.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn voxdag_colors(
    scene: *const VoxdagScene,
    count: usize,
    voxels: *const u64,
    rgba: *mut u8,
    error: *mut VoxdagError,
) -> VoxdagStatus {
    // SAFETY: what the header asks for.
    let caller = unsafe { Caller::new() };
    caller.run(error, || {
        let VoxdagScene { scene, palette, .. } = caller.one("scene", scene)?;
        let looks = scene.looks();
        let voxels = caller.slice("voxels", voxels, count)?;
        for (place, code) in caller.room("rgba", rgba.cast::<[u8; 4]>(), count)?.iter_mut().zip(voxels) {
            let textured = |voxel: &Morton| palette.get(usize::from(looks.id(*voxel))).is_some_and(|m| m.textured);
            let color = voxel(*code).filter(textured).and_then(|voxel| looks.color(voxel));
            place.write(color.map_or([0; 4], |[r, g, b]| [r, g, b, 255]));
        }
        Ok(())
    })
}

pub(crate) fn normal_kind(number: u32) -> Result<NormalKind, Failure> {
    NormalKind::ALL.get(number as usize).copied().ok_or(Failure::Choice { name: "kind of normals", found: number })
}

/// Hits whose normals are worked out together.
const CHUNK: usize = 64;
const MISS: Hit = Hit { voxel: Morton(0), from: None, t: 0.0, level: 0, face: Face::Inside };
const NO_NORMAL: Normal = Normal { direction: [0.0; 3], confidence: voxdag::normal::Confidence::Face };

/// What of a hit normals go by; `None` for a miss.
fn hit_at(code: u64, side: u32, position: u64) -> Result<Option<Hit>, Failure> {
    let Some(voxel) = voxel(code) else { return Ok(None) };
    let face = face(side).ok_or(Failure::Item { name: "face of a hit", position, found: side.into() })?;
    Ok(Some(Hit { voxel, face, ..MISS }))
}
