/* voxdag: sparse voxel DAGs with materials, for C99 and later and C++.
 *
 * Made by cbindgen from the sources in core/capi/src; see core/capi/tests/header.rs. How to build and link the library, and
 * a first program: docs/embedding.md.
 *
 * What holds for every function:
 *
 * - Memory is the caller's: arrays are read and written during the call only, except for the words of
 *   voxdag_scene_open(). What is written must not overlap anything else that the call reads or writes. It need not be
 *   cleared before. Pointers may be null where that is said, and where the count beside them is 0.
 * - Null pointers, pointers that are not aligned, sizes that overflow, numbers that are not finite or out of range are
 *   answered by a status; flags that are not 0 count as 1, and codes of voxels from 2^63 on, but for VOXDAG_NONE, as any
 *   voxel: they break nothing. A pointer to less memory than the count says, or to memory that was freed, cannot be noticed.
 * - The status is VOXDAG_STATUS_OK (0) or says what is wrong. `error` may be null; otherwise more is written to it where the
 *   status is not OK. Output other than the error is then undefined, but for what is said to be written.
 * - A scene never changes: any number of threads may use it at the same time. Functions keep nothing between calls.
 * - Queries take nothing from the heap, and give the same bits on every machine.
 * - The thread's floating-point environment is the default one: rounding to nearest, subnormals not flushed to 0 (no FTZ or
 *   DAZ), nothing linked with -ffast-math.
 * - No panic crosses the border: a defect of the library ends as VOXDAG_STATUS_PANIC, with a message on standard error. */

#ifndef VOXDAG_H
#define VOXDAG_H

#include <stddef.h>
#include <stdint.h>

// The version of this header. A program may compare it with `voxdag_abi_version()`.
#define VOXDAG_ABI_VERSION 1

// No voxel, and no position.
#define VOXDAG_NONE UINT64_MAX

// What became of a call. Later versions may add values: treat unknown ones as errors.
enum VoxdagStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // It did what it is for.
  VOXDAG_STATUS_OK = 0,
  // A pointer is null that must not be.
  VOXDAG_STATUS_NULL = 1,
  // A pointer is not aligned as its type asks.
  VOXDAG_STATUS_MISALIGNED = 2,
  // So many items that no memory holds them.
  VOXDAG_STATUS_COUNT = 3,
  // A number that means nothing there: of a choice, a flag, not finite, or out of range.
  VOXDAG_STATUS_ARGUMENT = 4,
  // The memory lent is too small; the error says how much is enough.
  VOXDAG_STATUS_TOO_SMALL = 5,
  // The heap refused, or the memory limit did.
  VOXDAG_STATUS_MEMORY = 6,
  // A defect of this library: the call ended half way, its output is undefined, the scene can still be used.
  VOXDAG_STATUS_PANIC = 7,
  // Not a .vxd file.
  VOXDAG_STATUS_FILE_MAGIC = 16,
  // The words of the file are in the other byte order.
  VOXDAG_STATUS_FILE_ENDIANNESS = 17,
  // A version of the file that this library does not know.
  VOXDAG_STATUS_FILE_VERSION = 18,
  // The file is shorter or longer than it says.
  VOXDAG_STATUS_FILE_LENGTH = 19,
  // A checksum of the file is wrong.
  VOXDAG_STATUS_FILE_CHECKSUM = 20,
  // Sections of the file are missing, double, or out of place.
  VOXDAG_STATUS_FILE_SECTION = 21,
  // The file's header is malformed.
  VOXDAG_STATUS_FILE_HEADER = 22,
  // The file's voxels are malformed.
  VOXDAG_STATUS_FILE_GEOMETRY = 23,
  // The file's materials, names or colours are malformed.
  VOXDAG_STATUS_FILE_MATERIALS = 24,
  // A mesh without triangles, or with too many.
  VOXDAG_STATUS_MESH_SIZE = 32,
  // A coordinate that is not finite; `position` is the vertex.
  VOXDAG_STATUS_MESH_NOT_FINITE = 33,
  // A triangle names a vertex that does not exist; `position` is the triangle.
  VOXDAG_STATUS_MESH_INDEX = 34,
  // A triangle names a material that does not exist; `position` is the triangle.
  VOXDAG_STATUS_MESH_MATERIAL = 35,
  // A vertex outside the grid; `position` is the vertex.
  VOXDAG_STATUS_MESH_OUTSIDE = 36,
  // A grid whose resolution, voxel size or origin is out of range.
  VOXDAG_STATUS_GRID = 37,
  // A material with a number that is not finite or below 0, or with a texture that has no pixels; `position` is the
  // material.
  VOXDAG_STATUS_MATERIAL = 38,
  // A name that is not UTF-8; `position` is the material.
  VOXDAG_STATUS_NAME = 39,
  // Width or height is out of range.
  VOXDAG_STATUS_PICTURE_SIZE = 48,
  // Rows that are not in the picture.
  VOXDAG_STATUS_PICTURE_ROWS = 49,
  // A camera that sees nothing.
  VOXDAG_STATUS_CAMERA = 50,
  // A light of no kind, nowhere, or with a number that is not finite or out of range; `position` is the light.
  VOXDAG_STATUS_LIGHT = 51,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagStatus VoxdagStatus;
#else
typedef int32_t VoxdagStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How the tracer decides which voxel comes first.
enum VoxdagArithmetic
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // For the real line, always (the default).
  VOXDAG_ARITHMETIC_EXACT = 0,
  // By rounded double alone.
  VOXDAG_ARITHMETIC_F64 = 1,
  // By rounded float alone, for many rays: a preview. Single rays are exact.
  VOXDAG_ARITHMETIC_F32 = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagArithmetic VoxdagArithmetic;
#else
typedef uint32_t VoxdagArithmetic;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The side of a voxel through which a ray came in.
enum VoxdagFace
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // x = k: the ray runs towards +x.
  VOXDAG_FACE_NEG_X = 0,
  // x = k + 1.
  VOXDAG_FACE_POS_X = 1,
  // y = k.
  VOXDAG_FACE_NEG_Y = 2,
  // y = k + 1.
  VOXDAG_FACE_POS_Y = 3,
  // z = k.
  VOXDAG_FACE_NEG_Z = 4,
  // z = k + 1.
  VOXDAG_FACE_POS_Z = 5,
  // The ray starts inside the voxel.
  VOXDAG_FACE_INSIDE = 6,
  // The ray missed.
  VOXDAG_FACE_NONE = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagFace VoxdagFace;
#else
typedef uint32_t VoxdagFace;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Which axis of the world points up.
enum VoxdagUp
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // +y is up, +z towards the viewer.
  VOXDAG_UP_Y = 0,
  // +z is up, -y towards the viewer.
  VOXDAG_UP_Z = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagUp VoxdagUp;
#else
typedef uint32_t VoxdagUp;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where normals come from.
enum VoxdagNormals
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The side of the voxel through which the ray came.
  VOXDAG_NORMALS_FACE = 0,
  // As kept with the materials; PLANE2 where none is.
  VOXDAG_NORMALS_STORED = 1,
  // From the six neighbours: one of 26 directions.
  VOXDAG_NORMALS_GRADIENT = 2,
  // The plane through the 3^3 voxels around: about 6 degrees off on a curved surface.
  VOXDAG_NORMALS_PLANE1 = 3,
  // The plane through the 5^3 voxels around: about 2 degrees off (the best choice for most).
  VOXDAG_NORMALS_PLANE2 = 4,
  // The plane through the 7^3 voxels around: about 1 degree off, and wider corners.
  VOXDAG_NORMALS_PLANE3 = 5,
  // The plane of Ernerfeldt through the 3^3 voxels around, to compare with.
  VOXDAG_NORMALS_ERNERFELDT1 = 6,
  // The plane of Ernerfeldt through the 5^3 voxels around, to compare with.
  VOXDAG_NORMALS_ERNERFELDT2 = 7,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagNormals VoxdagNormals;
#else
typedef uint32_t VoxdagNormals;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where a light is.
enum VoxdagLightKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // At a position.
  VOXDAG_LIGHT_KIND_POINT = 0,
  // Infinitely far away, in a direction as seen from the scene.
  VOXDAG_LIGHT_KIND_DIRECTIONAL = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagLightKind VoxdagLightKind;
#else
typedef uint32_t VoxdagLightKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Which pixels take all samples.
enum VoxdagSupersample
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Every pixel.
  VOXDAG_SUPERSAMPLE_ALL = 0,
  // Those of a rectangle; the others take their centre.
  VOXDAG_SUPERSAMPLE_REGION = 1,
  // Those whose corner samples do not all see one smooth surface; every pixel where there are fewer than 16 samples.
  VOXDAG_SUPERSAMPLE_ADAPTIVE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagSupersample VoxdagSupersample;
#else
typedef uint32_t VoxdagSupersample;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Effects that may be drawn, one bit each. Those that materials and lights do not call for cost nothing.
enum VoxdagEffects
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Matte surfaces in light that nothing keeps away.
  VOXDAG_EFFECTS_NONE = 0,
  // Highlights.
  VOXDAG_EFFECTS_SPECULAR = 1,
  // Shadows of the lights that cast them.
  VOXDAG_EFFECTS_SHADOWS = 2,
  // Reflections.
  VOXDAG_EFFECTS_MIRROR = 4,
  // Seeing through.
  VOXDAG_EFFECTS_TRANSPARENCY = 8,
  // Rays that bend where they enter and leave.
  VOXDAG_EFFECTS_REFRACTION = 16,
  // Light of its own.
  VOXDAG_EFFECTS_EMISSION = 32,
  // Colours of textures.
  VOXDAG_EFFECTS_TEXTURES = 64,
  // All there are.
  VOXDAG_EFFECTS_ALL = 127,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagEffects VoxdagEffects;
#else
typedef uint32_t VoxdagEffects;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Which voxels a triangle fills.
enum VoxdagCover
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Those that it meets: rays cannot pass (the default).
  VOXDAG_COVER_EXACT = 0,
  // Those whose centre cross it pierces: thinner, rays may slip through edges.
  VOXDAG_COVER_THIN = 1,
  // Those that it comes within 1/512 of a voxel of.
  VOXDAG_COVER_INFLATED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagCover VoxdagCover;
#else
typedef uint32_t VoxdagCover;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How materials are kept.
enum VoxdagKeep
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // A tree over space; the smallest and the fastest (the default).
  VOXDAG_KEEP_TREE = 0,
  // A hash table without normals.
  VOXDAG_KEEP_TABLE = 1,
  // A hash table with the normals of the triangles: `VOXDAG_NORMALS_STORED`.
  VOXDAG_KEEP_TABLE_NORMALS = 2,
  // Not at all: every voxel has material 0.
  VOXDAG_KEEP_NONE = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagKeep VoxdagKeep;
#else
typedef uint32_t VoxdagKeep;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How the colours of textures are kept.
enum VoxdagColors
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Blocks of 64 voxels between two colours each: some 5 bits a voxel, nearly the same colours (the default).
  VOXDAG_COLORS_BLOCKS = 0,
  // 24 bits a voxel, the very same colours.
  VOXDAG_COLORS_RAW = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum VoxdagColors VoxdagColors;
#else
typedef uint32_t VoxdagColors;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A scene that was opened. It never changes: any number of threads may use it at the same time.
typedef struct VoxdagScene VoxdagScene;

// A picture as it lies on surfaces; it is read during the call only. Begin with `voxdag_texture_default()`, which is none.
typedef struct VoxdagTexture {
  // 4 * width * height bytes, row by row from the top: red, green, blue in sRGB, and opacity (255 opaque). Null: no
  // texture. Textures with the same pixels, width and height share one picture.
  const uint8_t *pixels;
  // Pixels of a row.
  uint32_t width;
  // Rows.
  uint32_t height;
  // Factors on u and v.
  float scale[2];
  // What is added to the scaled u and v.
  float offset[2];
  // What is added to the picture's values.
  float base;
  // Factor on the picture's values.
  float gain;
  // Whether the picture ends in its borders outside 0 to 1 (1) or is repeated (0).
  uint32_t clamp;
} VoxdagTexture;

// What to build. Begin with `voxdag_build_default()`.
typedef struct VoxdagBuild {
  // Voxels along the longest axis, 1 to 2^21.
  uint32_t resolution;
  // `VOXDAG_COVER_*`.
  uint32_t cover;
  // `VOXDAG_KEEP_*`; with `VOXDAG_KEEP_NONE` textures are left out, too.
  uint32_t keep;
  // `VOXDAG_COLORS_*`.
  uint32_t colors;
  // `VOXDAG_UP_*`, for the default view.
  uint32_t up;
  // Side of a voxel in world units, for a grid of the caller's choice that holds the whole mesh; 0: the smallest grid
  // of `resolution` voxels around the mesh.
  double voxel_size;
  // World position of the corner of voxel (0, 0, 0) of such a grid.
  double origin[3];
  // Metres per world unit, for the file; 0 if nobody knows.
  double metres_per_unit;
  // Most bytes of the heap that building may take, about; UINT64_MAX for no limit.
  uint64_t memory_limit;
} VoxdagBuild;

// What a surface looks like. Colours are linear light, red, green, blue; every number is finite and 0 or more.
typedef struct VoxdagMaterial {
  // Ka: share of the ambient light that comes back.
  float ambient[3];
  // Kd: matte reflection.
  float diffuse[3];
  // Ks: highlight, mirror.
  float specular[3];
  // Ke: own light.
  float emission[3];
  // Tf: light let through.
  float transmission[3];
  // d: 1 is solid, 0 is invisible.
  float opacity;
  // Ni: optical density.
  float refraction;
  // Ns: the highlight's exponent, 1 to 1,000,000; others are moved into that range.
  uint32_t shininess;
  // illum: the illumination model of MTL files, 0 to 10.
  uint32_t illum;
  // Whether voxels have colours that it is multiplied by (1) or not (0). `voxdag_build` does not read
  // it: it takes textures.
  uint32_t textured;
} VoxdagMaterial;

// Triangles over shared vertices.
typedef struct VoxdagMesh {
  // Number of vertices, below 2^32.
  size_t vertex_count;
  // Number of triangles, 1 to 2^31 - 1.
  size_t triangle_count;
  // 3 * vertex_count numbers: x, y, z of each in world units.
  const double *positions;
  // 3 * triangle_count numbers: the vertices of each, counter-clockwise as seen from outside.
  const uint32_t *indices;
  // The material of each triangle, triangle_count numbers; null: 0 for all.
  const uint16_t *triangle_materials;
  // Number of materials, at most 65,536; 0: one, `voxdag_material_default()`.
  size_t material_count;
  // The materials.
  const struct VoxdagMaterial *materials;
  // Their names, material_count texts in UTF-8 that end with a zero byte; null: none, and each of them may be.
  const char *const *names;
  // Texture coordinates, 6 * triangle_count numbers: u, v at each of a triangle's corners; (0, 0) is the lower left corner
  // of a picture, v goes up. Null: none, and textures are not used. Triangles with one that is not finite are white.
  const float *uvs;
  // What colours the voxels of each material, in place of map_Kd: material_count textures; null: none. The colours multiply
  // `ambient` and `diffuse`.
  const struct VoxdagTexture *textures;
  // What cuts each material out, in place of map_d: material_count textures; null: none. A triangle fills a voxel only if
  // the picture leaves half or more of it: by its opacity, or, of an opaque picture, by its brightness.
  const struct VoxdagTexture *cutouts;
} VoxdagMesh;

// More about an error, in memory that the caller lends: written where a function does not return `VOXDAG_STATUS_OK`, left
// as it is otherwise.
typedef struct VoxdagError {
  // What the function returned.
  VoxdagStatus status;
  // Bytes of `message` before its zero byte.
  uint32_t length;
  // Which item is wrong, counted from 0: a vertex, triangle, material, light, hit, or word of the file or of its section;
  // the message says which. `VOXDAG_NONE` if it is no single one.
  uint64_t position;
  // What would be enough: words, pixels or bytes where the lent memory is too small, bytes where memory could not be
  // had; otherwise 0.
  uint64_t needed;
  // One sentence in English for people: UTF-8, ends with a zero byte.
  char message[256];
} VoxdagError;

// A ray in grid coordinates, in which voxel k spans k to k + 1: grid = (world - origin) / voxel_size. A direction in the
// world's axes is as good, as t is measured in units of it; divided by voxel_size, too, t is that of the world.
// A ray with a direction that is 0, or with a number that is NaN or infinite where it must not be, misses.
typedef struct VoxdagRay {
  // Where t is 0.
  double origin[3];
  // Any length.
  double direction[3];
  // Hits before it do not count.
  double t_min;
  // Hits at or after it do not count; infinity for all.
  double t_max;
  // Start in this empty voxel, which the ray passes, instead of where the origin lies: for a ray that leaves a surface, the
  // `from` of the hit there. `VOXDAG_NONE` for none.
  uint64_t start;
  // Cubes of 2^min_level voxels a side count as filled if anything in them is; 0 for voxels, at most 21.
  uint32_t min_level;
  // `VOXDAG_ARITHMETIC_*`; 0 is exact.
  uint32_t arithmetic;
} VoxdagRay;

// Where a ray ends.
typedef struct VoxdagHit {
  // The voxel's Morton code: `voxdag_voxel_position`. `VOXDAG_NONE` if the ray missed.
  uint64_t voxel;
  // The last empty voxel before it; `VOXDAG_NONE` if the ray starts in the hit or comes from outside the grid.
  uint64_t from;
  // Entry, in units of the direction; infinity if the ray missed or if it is too large for a number; `t_min` if the ray
  // starts inside.
  double t;
  // 0 for a voxel, else the ray's `min_level`, at most the scene's depth.
  uint32_t level;
  // `VOXDAG_FACE_*`.
  uint32_t face;
} VoxdagHit;

// Many rays as arrays; see `VoxdagRay`.
typedef struct VoxdagRays {
  // How many rays there are.
  size_t count;
  // 3 * count numbers: x, y, z of each.
  const double *origins;
  // 3 * count numbers: x, y, z of each.
  const double *directions;
  // count numbers, or null: 0 for all.
  const double *t_min;
  // count numbers, or null: infinity for all.
  const double *t_max;
  // count voxels, or null: none.
  const uint64_t *starts;
  // Of all rays.
  uint32_t min_level;
  // Of all rays.
  uint32_t arithmetic;
} VoxdagRays;

// Room for many hits as arrays of as many items as there are rays; see `VoxdagHit`. What is null is not written.
typedef struct VoxdagHits {
  // `VOXDAG_NONE` for a miss. Must not be null.
  uint64_t *voxels;
  // May be null.
  uint64_t *from;
  // May be null.
  double *t;
  // `VOXDAG_FACE_*`; may be null.
  uint8_t *faces;
} VoxdagHits;

// How a picture is made. Begin with `voxdag_settings_default()`.
typedef struct VoxdagSettings {
  // Pixels per row, 1 to 65,536.
  uint32_t width;
  // Rows, 1 to 65,536.
  uint32_t height;
  // Samples of a pixel: 1, 4, 5, 16 or 64.
  uint32_t samples;
  // `VOXDAG_SUPERSAMPLE_*`: which pixels take all of them.
  uint32_t supersample;
  // For REGION: first column and row, the column and the row after the last ones.
  uint32_t region[4];
  // For ADAPTIVE: how many degrees the normals of one surface may differ, 0 to 90.
  float degrees;
  // `VOXDAG_NORMALS_*`.
  uint32_t normals;
  // `VOXDAG_ARITHMETIC_*`.
  uint32_t arithmetic;
  // Sum of `VOXDAG_EFFECTS_*`.
  uint32_t effects;
  // Linear colour of the light that comes from everywhere.
  float ambient[3];
  // Linear colour where there is nothing.
  float background[3];
  // How high above a surface the rays start that leave it, in steps of voxels, 0 to 16; 1 is just above its steps, 0 on
  // them.
  float lift;
} VoxdagSettings;

// A pinhole camera in the world.
typedef struct VoxdagCamera {
  // Where it is.
  double eye[3];
  // What it looks at: the middle of the picture.
  double target[3];
  // What points upwards in the picture, of any length.
  double up[3];
  // Angle between the picture's top and bottom in degrees, above 0 and below 180.
  double fov_y;
} VoxdagCamera;

// A light in the world; its strength does not fall with distance.
typedef struct VoxdagLight {
  // `VOXDAG_LIGHT_KIND_*`.
  uint32_t kind;
  // Whether what stands in its way casts a shadow: 1 or 0.
  uint32_t shadow;
  // The position, or the direction, of any length but 0.
  double position[3];
  // Linear red, green, blue, none below 0; 1 is white at full strength.
  float color[3];
} VoxdagLight;

// How many rays were traced.
typedef struct VoxdagCounters {
  // From the camera.
  uint64_t primary;
  // Towards lights that cast shadows.
  uint64_t shadow;
  // That go on from surfaces.
  uint64_t secondary;
  // Primary ones that met a voxel.
  uint64_t hits;
} VoxdagCounters;

// What a scene is.
typedef struct VoxdagSceneInfo {
  // Voxels along the longest axis, 1 to 2^21.
  uint32_t resolution;
  // Octree levels: the smallest L with 2^L >= resolution.
  uint32_t depth;
  // Number of materials, 1 to 65,536.
  uint32_t material_count;
  // `VOXDAG_UP_*`.
  uint32_t up;
  // Whether voxels have normals of their own (1) or not (0): `VOXDAG_NORMALS_STORED`.
  uint32_t has_normals;
  // Whether voxels have colours (1) or not (0): `voxdag_colors`.
  uint32_t has_colors;
  // Filled voxels.
  uint64_t voxel_count;
  // Words of the file.
  uint64_t word_count;
  // Bytes of the heap that the trees take.
  uint64_t tree_bytes;
  // World position of the corner of voxel (0, 0, 0): world = origin + voxel_size * grid, for each axis.
  double origin[3];
  // Side of a voxel in world units.
  double voxel_size;
  // The mesh's box in world units: smallest coordinates,
  double bounds_min[3];
  // and largest ones.
  double bounds_max[3];
  // Metres per world unit; 0 if nobody said.
  double metres_per_unit;
} VoxdagSceneInfo;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// The ABI of the library that was linked or loaded: `VOXDAG_ABI_VERSION` of its header. The same number means that a
// program may go on; the number changes where a function, a structure or a meaning does, and not where one is added.
uint32_t voxdag_abi_version(void);

// The version of the library, such as "0.1.0": a text that lives for ever.
const char *voxdag_version(void);

// A status (`VOXDAG_STATUS_*`) in words, without places and numbers, which a `VoxdagError` has: a text that lives for ever.
const char *voxdag_error_message(int32_t status);

// No texture. Once it has pixels: the picture as it is, once per unit of u and v, again and again.
struct VoxdagTexture voxdag_texture_default(void);

// 512 voxels along the longest axis of the smallest grid around the mesh, exact cover, a tree of materials, y up, no limit.
struct VoxdagBuild voxdag_build_default(void);

// Builds a scene from triangles: the words of a .vxd file, for `voxdag_scene_open` or, low byte first, for a file. The same
// mesh gives the same words on every machine. What is worked with comes from the heap and is given back.
//
// words: room for `room` words. If they are too few, the status is `VOXDAG_STATUS_TOO_SMALL`, and nothing is written to
// them; null and 0 only ask. Asking takes as long as building, so lend generously, or keep what does not change.
// word_count: how many words the file has; also written if the room is too small.
VoxdagStatus voxdag_build(const struct VoxdagMesh *mesh,
                          const struct VoxdagBuild *build,
                          uint32_t *words,
                          size_t room,
                          size_t *word_count,
                          struct VoxdagError *error);

// The ray from (0, 0, 0) without a direction, to be filled in: all hits count, exactly.
struct VoxdagRay voxdag_ray_default(void);

// The first filled voxel that a ray meets.
VoxdagStatus voxdag_trace(const struct VoxdagScene *scene,
                          const struct VoxdagRay *ray,
                          struct VoxdagHit *hit,
                          struct VoxdagError *error);

// The first filled voxel that each of many rays meets: the same answers as one by one, faster with trees, fastest for some
// hundred rays or more that are near each other. Takes up to 100 KiB of stack, no heap.
VoxdagStatus voxdag_trace_many(const struct VoxdagScene *scene,
                               const struct VoxdagRays *rays,
                               const struct VoxdagHits *hits,
                               struct VoxdagError *error);

// Whether a ray meets any filled voxel: 1 or 0 in `blocked`. Faster than to find out where.
VoxdagStatus voxdag_occluded(const struct VoxdagScene *scene,
                             const struct VoxdagRay *ray,
                             uint8_t *blocked,
                             struct VoxdagError *error);

// Whether each of many rays meets any filled voxel: 1 or 0 in `blocked`, one byte a ray.
VoxdagStatus voxdag_occluded_many(const struct VoxdagScene *scene,
                                  const struct VoxdagRays *rays,
                                  uint8_t *blocked,
                                  struct VoxdagError *error);

// The coordinates x, y, z of a voxel, in 3 numbers of `position`.
VoxdagStatus voxdag_voxel_position(uint64_t voxel, uint32_t *position, struct VoxdagError *error);

// The voxel at the coordinates x, y, z; `VOXDAG_NONE` if one is 2^21 or more.
uint64_t voxdag_voxel_at(uint32_t x, uint32_t y, uint32_t z);

// 1024 x 1024, one sample, exact rays, `VOXDAG_NORMALS_PLANE2`, faint ambient light, a light grey background, all effects
// that the scene calls for.
struct VoxdagSettings voxdag_settings_default(void);

// The default view of a scene: all of it, from the right, above and in front; and the default light, white, above the eye,
// without shadows. `light` may be null.
VoxdagStatus voxdag_camera_default(const struct VoxdagScene *scene,
                                   struct VoxdagCamera *camera,
                                   struct VoxdagLight *light,
                                   struct VoxdagError *error);

// Draws the rows `first_row` to `end_row - 1` (row 0 is the top) of a picture. Pixels depend on nothing but scene, camera,
// lights, settings and their place: threads may draw rows of one picture at the same time; fastest for a multiple of 4.
// Takes up to 350 KiB of stack where rays go on from surfaces, else 200 KiB; the heap only for lights.
//
// lights: `light_count` of them; null if there are none.
// pixels: room for `pixel_count` pixels, at least (end_row - first_row) * width, row by row: red in the lowest 8 bits, then
// green, then blue, then 255, so on a machine that stores the low byte first the bytes R, G, B, A.
// counters: may be null.
VoxdagStatus voxdag_render_rows(const struct VoxdagScene *scene,
                                const struct VoxdagCamera *camera,
                                const struct VoxdagLight *lights,
                                size_t light_count,
                                const struct VoxdagSettings *settings,
                                uint32_t first_row,
                                uint32_t end_row,
                                uint32_t *pixels,
                                size_t pixel_count,
                                struct VoxdagCounters *counters,
                                struct VoxdagError *error);

// Opens a scene: checks the words of a .vxd file, all of them, and makes trees over them. The words are neither copied nor
// changed; they must stay as and where they are until the scene is closed. O(words).
//
// A word is 4 bytes of the file, low byte first: on a machine that stores the low byte first, a file read into memory
// that is aligned to 4 bytes.
//
// tree_bytes: most bytes of the heap that the trees may take. They make rays some times faster and change no answer. 0:
// none, for little memory or a few rays; UINT64_MAX: no limit. What does not fit is left out.
// scene: where the handle goes; nothing is written if the scene is refused. Close it with `voxdag_scene_close`.
VoxdagStatus voxdag_scene_open(const uint32_t *words,
                               size_t word_count,
                               uint64_t tree_bytes,
                               struct VoxdagScene **scene,
                               struct VoxdagError *error);

// The same from bytes of any alignment, on any machine: they are copied, and may be freed after the call.
VoxdagStatus voxdag_scene_open_bytes(const uint8_t *bytes,
                                     size_t byte_count,
                                     uint64_t tree_bytes,
                                     struct VoxdagScene **scene,
                                     struct VoxdagError *error);

// Closes a scene, which must not be used any more, by no thread. Null is nothing.
void voxdag_scene_close(struct VoxdagScene *scene);

// What a scene is. Counts voxels: O(words), with memory from the heap.
VoxdagStatus voxdag_scene_info(const struct VoxdagScene *scene,
                               struct VoxdagSceneInfo *info,
                               struct VoxdagError *error);

// The parameters of a material, 0 to `material_count - 1`.
VoxdagStatus voxdag_scene_material(const struct VoxdagScene *scene,
                                   uint32_t id,
                                   struct VoxdagMaterial *material,
                                   struct VoxdagError *error);

// The name of a material, UTF-8 with a zero byte after it, in `room` bytes of `name`. If they are too few, what is needed,
// the zero byte included, is in `error->needed`.
VoxdagStatus voxdag_scene_material_name(const struct VoxdagScene *scene,
                                        uint32_t id,
                                        char *name,
                                        size_t room,
                                        struct VoxdagError *error);

// The material that stands in where a mesh names none: grey, matte.
struct VoxdagMaterial voxdag_material_default(void);

// The surface's direction at a hit: a unit vector out of the surface, 3 numbers.
//
// kind: `VOXDAG_NORMALS_*`. direction: 3 numbers, the ray's. Of the hit, `voxel` and `face` count; of a miss the normal is
// 0, 0, 0.
VoxdagStatus voxdag_normal(const struct VoxdagScene *scene,
                           uint32_t kind,
                           const struct VoxdagHit *hit,
                           const double *direction,
                           float *normal,
                           struct VoxdagError *error);

// The surface's directions at many hits, the same answers as one by one; fastest where hits that follow each other are
// near each other. Takes up to 30 KiB of stack, no heap.
//
// voxels, faces: `count` items, as `voxdag_trace_many` wrote them. directions: 3 * count numbers, those of the rays.
// normals: room for 3 * count numbers.
VoxdagStatus voxdag_normals(const struct VoxdagScene *scene,
                            uint32_t kind,
                            size_t count,
                            const uint64_t *voxels,
                            const uint8_t *faces,
                            const double *directions,
                            float *normals,
                            struct VoxdagError *error);

// The materials of `count` voxels, one or many: numbers for `voxdag_scene_material`. UINT32_MAX for `VOXDAG_NONE`; a voxel
// that is not filled has some material.
VoxdagStatus voxdag_materials(const struct VoxdagScene *scene,
                              size_t count,
                              const uint64_t *voxels,
                              uint32_t *ids,
                              struct VoxdagError *error);

// The colours that textures gave to `count` voxels, one or many: 4 bytes each, red, green, blue in sRGB and 255; all 0
// where there is none. A material that is `textured` is multiplied by the colour, once that is decoded to linear light.
VoxdagStatus voxdag_colors(const struct VoxdagScene *scene,
                           size_t count,
                           const uint64_t *voxels,
                           uint8_t *rgba,
                           struct VoxdagError *error);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* VOXDAG_H */
