/* Embree's single-ray rates on a mesh, measured as `voxdag bench trace` measures ours.
 *
 * In: an OBJ, a camera, the size of a picture. Out: one line of JSON: rtcIntersect1 on one ray through the centre of
 * every pixel, rtcOccluded1 from its hits to centre + 3 R (0.3, 1, 0.4)/|.| of the mesh's box, and rtcIntersect1 from
 * the hits in random directions, all of the sphere alike. Rays lie ready in memory as RTCRayHit and RTCRay, in the
 * order of the pixels; only the calls are timed, by the thread's CPU time; medians of repetitions.
 *
 *   compare MESH.obj WxH REPEAT FOV EYE TARGET      EYE and TARGET are x,y,z, or - for voxdag's default view
 */
#define _GNU_SOURCE
#include <embree3/rtcore.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct { double x, y, z; } Vec;

static Vec add(Vec a, Vec b, double s) { return (Vec){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s}; }
static double dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vec cross(Vec a, Vec b) { return (Vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static Vec unit(Vec a) { return add((Vec){0, 0, 0}, a, 1 / sqrt(dot(a, a))); }

static void fail(const char *what) {
    fprintf(stderr, "compare: %s\n", what);
    exit(1);
}

static void *grown(void *list, size_t count, size_t *room, size_t size) {
    if (count < *room) return list;
    *room = *room ? 2 * *room : 1 << 16;
    list = realloc(list, *room * size);
    if (!list) fail("out of memory");
    return list;
}

static double *vertices;
static unsigned *triangles;
static size_t vertex_count, triangle_count;

/* Reads `v` and `f` lines; polygons become fans. */
static void read_obj(const char *path) {
    FILE *file = fopen(path, "r");
    if (!file) fail("cannot open the mesh");
    char *line = NULL;
    size_t length = 0, vertex_room = 0, triangle_room = 0;
    while (getline(&line, &length, file) > 0) {
        if (line[0] == 'v' && (line[1] == ' ' || line[1] == '\t')) {
            vertices = grown(vertices, vertex_count, &vertex_room, 3 * sizeof *vertices);
            double *v = vertices + 3 * vertex_count++;
            if (sscanf(line + 2, "%lf %lf %lf", v, v + 1, v + 2) != 3) fail("a vertex without three numbers");
        } else if (line[0] == 'f' && (line[1] == ' ' || line[1] == '\t')) {
            unsigned face[3];
            int corners = 0;
            for (char *word = strtok(line + 2, " \t\r\n"); word; word = strtok(NULL, " \t\r\n")) {
                long index = strtol(word, NULL, 10);
                index = index < 0 ? (long)vertex_count + index : index - 1;
                if (index < 0 || index >= (long)vertex_count) fail("a face names a vertex that does not exist");
                face[corners < 2 ? corners : 2] = (unsigned)index;
                if (++corners >= 3) {
                    triangles = grown(triangles, triangle_count, &triangle_room, 3 * sizeof *triangles);
                    memcpy(triangles + 3 * triangle_count++, face, sizeof face);
                    face[1] = face[2];
                }
            }
        }
    }
    free(line);
    fclose(file);
    if (!triangle_count) fail("there are no faces in the mesh");
}

static RTCScene build(RTCDevice device) {
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *v = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertex_count);
    unsigned *t = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangle_count);
    if (!v || !t) fail("Embree has no memory for the mesh");
    for (size_t i = 0; i < 3 * vertex_count; i++) v[i] = (float)vertices[i];
    memcpy(t, triangles, 12 * triangle_count);
    rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("Embree cannot build the scene");
    return scene;
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Prints the rate by the median of the times, which it sorts, and the share of the rays that hit. */
static void print(const char *name, double *times, int repeat, size_t rays, size_t hits) {
    qsort(times, repeat, sizeof(double), ascending);
    printf("\"%s\": {\"mrays_per_s\": %.4f, \"hit_fraction\": %.6f}", name, rays ? rays / times[repeat / 2] / 1e6 : 0,
           rays ? (double)hits / rays : 0);
}

static struct RTCRay ray(Vec origin, Vec dir, float tnear, float tfar) {
    struct RTCRay r = {0};
    r.org_x = (float)origin.x, r.org_y = (float)origin.y, r.org_z = (float)origin.z, r.tnear = tnear;
    r.dir_x = (float)dir.x, r.dir_y = (float)dir.y, r.dir_z = (float)dir.z, r.tfar = tfar;
    r.mask = ~0u;
    return r;
}

static struct RTCRayHit nearest(struct RTCRay ray) {
    struct RTCRayHit r = {.ray = ray};
    r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

/* The next number of a seeded sequence, from -1 up to 1: splitmix64. */
static double next(uint64_t *state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9;
    x = (x ^ x >> 27) * 0x94d049bb133111eb;
    return (double)((x ^ x >> 31) >> 11) * 0x1p-52 - 1;
}

static Vec random_direction(uint64_t *state) {
    for (;;) {
        double x = next(state), y = next(state), z = next(state);
        Vec v = {x, y, z};
        if (dot(v, v) <= 1 && dot(v, v) > 1e-6) return v;
    }
}

static Vec vector(const char *text, Vec otherwise) {
    Vec v;
    if (!strcmp(text, "-")) return otherwise;
    if (sscanf(text, "%lf,%lf,%lf", &v.x, &v.y, &v.z) != 3) fail("expected three numbers x,y,z");
    return v;
}

int main(int argc, char **argv) {
    unsigned width, height;
    if (argc != 7 || sscanf(argv[2], "%ux%u", &width, &height) != 2) fail("MESH.obj WxH REPEAT FOV EYE TARGET");
    int repeat = atoi(argv[3]);
    double fov = atof(argv[4]);
    if (repeat < 1 || repeat > 1000 || !width || !height) fail("expected a size and 1 to 1000 repetitions");
    read_obj(argv[1]);

    /* The box of the vertices that faces use. */
    Vec low = {INFINITY, INFINITY, INFINITY}, high = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * triangle_count; i++) {
        const double *v = vertices + 3 * triangles[i];
        low = (Vec){fmin(low.x, v[0]), fmin(low.y, v[1]), fmin(low.z, v[2])};
        high = (Vec){fmax(high.x, v[0]), fmax(high.y, v[1]), fmax(high.z, v[2])};
    }
    Vec centre = add(low, add(high, low, -1), 0.5);
    Vec diagonal = add(high, low, -1);
    double radius = 0.5 * sqrt(dot(diagonal, diagonal));

    /* The rays of voxdag's camera, y up. */
    Vec target = vector(argv[6], centre);
    Vec eye = vector(argv[5], add(target, unit((Vec){1, 0.6, 1.2}), 2 * radius));
    Vec forward = unit(add(target, eye, -1));
    Vec up = unit(add((Vec){0, 1, 0}, forward, -forward.y));
    Vec right = cross(forward, up);
    double half = tan(fov * M_PI / 360), pixel = 2 * half / height;
    Vec corner = add(add(forward, right, -0.5 * pixel * width), up, half);

    RTCDevice device = rtcNewDevice("threads=1");
    if (!device) fail("Embree does not start");
    RTCScene scene = build(device);
    size_t count = (size_t)width * height, hits = 0, blocked = 0, random_hits = 0;
    struct RTCRayHit *rays = aligned_alloc(16, count * sizeof *rays);
    struct RTCRayHit *random = aligned_alloc(16, count * sizeof *random);
    struct RTCRay *shadow = aligned_alloc(16, count * sizeof *shadow);
    double *primary_times = calloc(repeat, sizeof(double)), *shadow_times = calloc(repeat, sizeof(double));
    double *random_times = calloc(repeat, sizeof(double));
    if (!rays || !random || !shadow || !primary_times || !shadow_times || !random_times) fail("out of memory");

    Vec light = add(centre, unit((Vec){0.3, 1, 0.4}), 3 * radius);
    for (int repetition = 0; repetition < repeat; repetition++) {
        for (size_t i = 0; i < count; i++) {
            Vec dir = add(add(corner, right, pixel * (i % width + 0.5)), up, -pixel * (i / width + 0.5));
            rays[i] = nearest(ray(eye, dir, 0, INFINITY));
        }
        struct RTCIntersectContext coherent, incoherent;
        rtcInitIntersectContext(&coherent);
        rtcInitIntersectContext(&incoherent);
        coherent.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        double start = now();
        for (size_t i = 0; i < count; i++) rtcIntersect1(scene, &coherent, &rays[i]);
        primary_times[repetition] = now() - start;

        hits = blocked = random_hits = 0;
        uint64_t state = 3;
        for (size_t i = 0; i < count; i++) {
            if (rays[i].hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
            struct RTCRay r = rays[i].ray;
            /* From just before the hit, as ours start in the voxel before: a wall without thickness blocks its far side. */
            double before = r.tfar * (1 - 1e-5);
            Vec point = add((Vec){r.org_x, r.org_y, r.org_z}, (Vec){r.dir_x, r.dir_y, r.dir_z}, before);
            shadow[hits] = ray(point, add(light, point, -1), 0, 1);
            random[hits++] = nearest(ray(point, random_direction(&state), 0, INFINITY));
        }
        start = now();
        for (size_t i = 0; i < hits; i++) rtcOccluded1(scene, &coherent, &shadow[i]);
        shadow_times[repetition] = now() - start;
        start = now();
        for (size_t i = 0; i < hits; i++) rtcIntersect1(scene, &incoherent, &random[i]);
        random_times[repetition] = now() - start;
        for (size_t i = 0; i < hits; i++) {
            blocked += shadow[i].tfar < 0;
            random_hits += random[i].hit.geomID != RTC_INVALID_GEOMETRY_ID;
        }
    }

    printf("{\"triangles\": %zu, ", triangle_count);
    print("primary", primary_times, repeat, count, hits);
    printf(", ");
    print("shadow", shadow_times, repeat, hits, blocked);
    printf(", ");
    print("random", random_times, repeat, hits, random_hits);
    printf("}\n");
    return 0;
}
