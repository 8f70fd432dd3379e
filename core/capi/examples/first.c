#include <stdio.h>
#include "voxdag.h"

int main(void) {
    static const double corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t triangle[] = {0, 1, 2};
    static uint32_t words[65536]; /* the scene, as a .vxd file has it */
    VoxdagMesh mesh = {.vertex_count = 3, .triangle_count = 1, .positions = corners, .indices = triangle};
    VoxdagBuild build = voxdag_build_default();
    VoxdagRay ray = voxdag_ray_default();
    VoxdagScene *scene;
    VoxdagHit hit;
    VoxdagError error;
    size_t count;

    ray.origin[0] = ray.origin[1] = 100.5; /* in voxels, of which there are 512 along the longest axis */
    ray.origin[2] = 600.0;
    ray.direction[2] = -1.0;
    if (voxdag_build(&mesh, &build, words, 65536, &count, &error) != VOXDAG_STATUS_OK ||
        voxdag_scene_open(words, count, UINT64_MAX, &scene, &error) != VOXDAG_STATUS_OK) {
        return fprintf(stderr, "%s\n", error.message), 1;
    }
    voxdag_trace(scene, &ray, &hit, NULL);
    printf("hit at %g\n", hit.t); /* 599: the triangle fills the lowest layer of voxels */
    voxdag_scene_close(scene);
    return 0;
}
