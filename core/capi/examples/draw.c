/* Loads a .vxd file, says what is in it, traces one ray, and draws a picture.
 *
 *     draw SCENE.vxd PICTURE.ppm [WIDTH HEIGHT]
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "voxdag.h"

/* Rows that are drawn at a time; threads could draw them side by side. */
#define BAND 16

static void fail(const char *what, const VoxdagError *error) {
    fprintf(stderr, "%s: %s\n", what, error->message);
    exit(1);
}

/* The bytes of a file, for free(). */
static uint8_t *read_file(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    uint8_t *bytes = NULL;
    long end;
    if (file && fseek(file, 0, SEEK_END) == 0 && (end = ftell(file)) > 0 && fseek(file, 0, SEEK_SET) == 0) {
        *size = (size_t)end;
        bytes = malloc(*size);
        if (bytes && fread(bytes, 1, *size, file) != *size) {
            free(bytes);
            bytes = NULL;
        }
    }
    if (file) fclose(file);
    if (!bytes) {
        fprintf(stderr, "%s cannot be read\n", path);
        exit(1);
    }
    return bytes;
}

/* The file's bytes are words as they are on machines that store the low byte first. */
static int low_byte_first(void) {
    const uint32_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

static void print_info(const VoxdagScene *scene, const VoxdagSceneInfo *info) {
    VoxdagError error;
    printf("resolution %u, depth %u, voxel size %.9g\n", info->resolution, info->depth, info->voxel_size);
    printf("voxels %llu in %llu words\n", (unsigned long long)info->voxel_count, (unsigned long long)info->word_count);
    for (uint32_t id = 0; id < info->material_count; id++) {
        VoxdagMaterial material;
        char name[256];
        if (voxdag_scene_material(scene, id, &material, &error) != VOXDAG_STATUS_OK) fail("material", &error);
        if (voxdag_scene_material_name(scene, id, name, sizeof name, &error) != VOXDAG_STATUS_OK) fail("name", &error);
        printf("material %u \"%s\" diffuse %.3f %.3f %.3f\n", id, name, material.diffuse[0], material.diffuse[1],
               material.diffuse[2]);
    }
}

/* The ray from the camera to what it looks at. */
static void trace_one(const VoxdagScene *scene, const VoxdagSceneInfo *info, const VoxdagCamera *camera) {
    VoxdagRay ray = voxdag_ray_default();
    VoxdagHit hit;
    VoxdagError error;
    float normal[3];
    uint32_t position[3], material;
    for (int i = 0; i < 3; i++) {
        /* From world to grid coordinates. t is then 0 at the eye and 1 at the target. */
        ray.origin[i] = (camera->eye[i] - info->origin[i]) / info->voxel_size;
        ray.direction[i] = (camera->target[i] - camera->eye[i]) / info->voxel_size;
    }
    if (voxdag_trace(scene, &ray, &hit, &error) != VOXDAG_STATUS_OK) fail("ray", &error);
    if (hit.voxel == VOXDAG_NONE) {
        printf("the middle of the picture is empty\n");
        return;
    }
    voxdag_voxel_position(hit.voxel, position, NULL);
    voxdag_normal(scene, VOXDAG_NORMALS_PLANE2, &hit, ray.direction, normal, NULL);
    voxdag_materials(scene, 1, &hit.voxel, &material, NULL);
    printf("hit voxel %u %u %u at t %.6f, normal %.3f %.3f %.3f, material %u\n", position[0], position[1], position[2],
           hit.t, normal[0], normal[1], normal[2], material);
}

static void draw(const VoxdagScene *scene, const VoxdagCamera *camera, const VoxdagLight *light,
                 const VoxdagSettings *settings, const char *path) {
    VoxdagError error;
    size_t room = (size_t)BAND * settings->width;
    uint32_t *pixels = malloc(room * sizeof *pixels);
    FILE *file = fopen(path, "wb");
    if (!file || !pixels) {
        fprintf(stderr, "%s cannot be written\n", path);
        exit(1);
    }
    fprintf(file, "P6\n%u %u\n255\n", settings->width, settings->height);
    for (uint32_t row = 0; row < settings->height; row += BAND) {
        uint32_t end = row + BAND < settings->height ? row + BAND : settings->height;
        if (voxdag_render_rows(scene, camera, light, 1, settings, row, end, pixels, room, NULL, &error) != VOXDAG_STATUS_OK)
            fail("picture", &error);
        for (size_t i = 0; i < (size_t)(end - row) * settings->width; i++) {
            uint8_t rgb[3] = {(uint8_t)pixels[i], (uint8_t)(pixels[i] >> 8), (uint8_t)(pixels[i] >> 16)};
            fwrite(rgb, 1, 3, file);
        }
    }
    fclose(file);
    free(pixels);
}

int main(int argc, char **argv) {
    VoxdagError error;
    VoxdagScene *scene;
    VoxdagSceneInfo info;
    VoxdagCamera camera;
    VoxdagLight light;
    VoxdagSettings settings = voxdag_settings_default();
    VoxdagStatus status;
    size_t size;
    uint8_t *bytes;
    if (argc != 3 && argc != 5) {
        fprintf(stderr, "usage: %s SCENE.vxd PICTURE.ppm [WIDTH HEIGHT]\n", argv[0]);
        return 2;
    }
    if (voxdag_abi_version() != VOXDAG_ABI_VERSION) {
        fprintf(stderr, "the library is of another ABI\n");
        return 1;
    }
    if (argc == 5) {
        settings.width = (uint32_t)strtoul(argv[3], NULL, 10);
        settings.height = (uint32_t)strtoul(argv[4], NULL, 10);
    }

    /* malloc aligns for words, so the file can be used where it lies. */
    bytes = read_file(argv[1], &size);
    status = low_byte_first() && size % 4 == 0
                 ? voxdag_scene_open((const uint32_t *)(const void *)bytes, size / 4, UINT64_MAX, &scene, &error)
                 : voxdag_scene_open_bytes(bytes, size, UINT64_MAX, &scene, &error);
    if (status != VOXDAG_STATUS_OK) fail(argv[1], &error);

    if (voxdag_scene_info(scene, &info, &error) != VOXDAG_STATUS_OK) fail("info", &error);
    if (voxdag_camera_default(scene, &camera, &light, &error) != VOXDAG_STATUS_OK) fail("camera", &error);
    print_info(scene, &info);
    trace_one(scene, &info, &camera);
    draw(scene, &camera, &light, &settings, argv[2]);
    voxdag_scene_close(scene);
    free(bytes);
    return 0;
}
