// Builds a scene from triangles, keeps it as a file, traces many rays at once, and shades the hits itself.
//
//     build SCENE.vxd PICTURE.ppm
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "voxdag.h"

namespace {

// A status other than OK, as an exception.
struct Error : std::runtime_error {
    explicit Error(const VoxdagError &error) : std::runtime_error(error.message), status(error.status) {}
    VoxdagStatus status;
};

// Calls a function with `arguments...` and room for an error after them.
template <class Function, class... Arguments>
void call(Function function, Arguments... arguments) {
    VoxdagError error;
    if (function(arguments..., &error) != VOXDAG_STATUS_OK) throw Error(error);
}

// A scene, with the words that it borrows.
class Scene {
  public:
    explicit Scene(std::vector<uint32_t> words) : words_(std::move(words)) {
        VoxdagScene *scene = nullptr;
        call(voxdag_scene_open, words_.data(), words_.size(), std::numeric_limits<uint64_t>::max(), &scene);
        scene_.reset(scene);
    }
    Scene(Scene &&) = default;
    // Would free the words of a scene that is still open.
    Scene &operator=(Scene &&) = delete;
    const VoxdagScene *get() const { return scene_.get(); }
    const std::vector<uint32_t> &words() const { return words_; }

  private:
    struct Close {
        void operator()(VoxdagScene *scene) const { voxdag_scene_close(scene); }
    };
    // Destroyed last, after the scene.
    std::vector<uint32_t> words_;
    std::unique_ptr<VoxdagScene, Close> scene_;
};

// The words of a scene of a mesh: a guess first, then as many as there are.
std::vector<uint32_t> build(const VoxdagMesh &mesh, const VoxdagBuild &options) {
    std::vector<uint32_t> words(100000);
    for (;;) {
        VoxdagError error;
        size_t count = 0;
        VoxdagStatus status = voxdag_build(&mesh, &options, words.data(), words.size(), &count, &error);
        if (status != VOXDAG_STATUS_OK && status != VOXDAG_STATUS_TOO_SMALL) throw Error(error);
        words.resize(count);
        if (status == VOXDAG_STATUS_OK) return words;
    }
}

void write_words(const char *path, const std::vector<uint32_t> &words) {
    std::ofstream file(path, std::ios::binary);
    for (uint32_t word : words) {
        const char bytes[] = {static_cast<char>(word), static_cast<char>(word >> 8), static_cast<char>(word >> 16),
                              static_cast<char>(word >> 24)};
        file.write(bytes, 4);
    }
    if (!file.flush()) throw std::runtime_error(std::string(path) + " cannot be written");
}

}  // namespace

int main(int argc, char **argv) try {
    if (argc != 3) {
        std::cerr << "usage: " << argv[0] << " SCENE.vxd PICTURE.ppm\n";
        return 2;
    }

    // A red octahedron over a grey floor, in metres, y up.
    const std::vector<double> positions = {0, 1, 0, 0, 3, 0, 1, 2, 0,  -1, 2, 0, 0, 2, 1,
                                           0, 2, -1, -2, 0, -2, 2, 0, -2, 2, 0, 2, -2, 0, 2};
    const std::vector<uint32_t> indices = {1, 4, 2, 1, 2, 5, 1, 5, 3, 1, 3, 4, 0, 2, 4, 0, 5,
                                           2, 0, 3, 5, 0, 4, 3, 6, 9, 8, 6, 8, 7};
    const std::vector<uint16_t> triangle_materials = {0, 0, 0, 0, 0, 0, 0, 0, 1, 1};
    VoxdagMaterial red = voxdag_material_default();
    red.diffuse[1] = red.diffuse[2] = 0.05F;
    const VoxdagMaterial materials[] = {red, voxdag_material_default()};
    const char *const names[] = {"red", "floor"};
    VoxdagMesh mesh{};
    mesh.vertex_count = positions.size() / 3;
    mesh.triangle_count = indices.size() / 3;
    mesh.positions = positions.data();
    mesh.indices = indices.data();
    mesh.triangle_materials = triangle_materials.data();
    mesh.material_count = 2;
    mesh.materials = materials;
    mesh.names = names;
    VoxdagBuild options = voxdag_build_default();
    options.resolution = 256;
    options.metres_per_unit = 1;

    const Scene scene(build(mesh, options));
    write_words(argv[1], scene.words());
    VoxdagSceneInfo info;
    call(voxdag_scene_info, scene.get(), &info);

    // Parallel rays downwards at a slant, in grid coordinates, row by row.
    constexpr size_t side = 192;
    const size_t count = side * side;
    std::vector<double> origins, directions;
    for (size_t i = 0; i < count; i++) {
        const double x = static_cast<double>(i % side) * 256 / side, y = static_cast<double>(i / side) * 256 / side;
        for (double k : {x + 0.5, 400.0, y + 200.5}) origins.push_back(k);
        for (double k : {0.0, -1.0, -0.5}) directions.push_back(k);
    }
    std::vector<uint64_t> voxels(count);
    std::vector<uint8_t> faces(count);
    VoxdagRays rays{};
    rays.count = count;
    rays.origins = origins.data();
    rays.directions = directions.data();
    VoxdagHits hits{};
    hits.voxels = voxels.data();
    hits.faces = faces.data();
    call(voxdag_trace_many, scene.get(), &rays, &hits);

    // What they hit: direction of the surface and material.
    std::vector<float> normals(3 * count);
    std::vector<uint32_t> ids(count);
    const uint32_t kind = VOXDAG_NORMALS_PLANE2;
    call(voxdag_normals, scene.get(), kind, count, voxels.data(), faces.data(), directions.data(), normals.data());
    call(voxdag_materials, scene.get(), count, voxels.data(), ids.data());

    // A picture of our own: the brighter, the more a surface looks up.
    std::ofstream picture(argv[2], std::ios::binary);
    picture << "P6\n" << side << ' ' << side << "\n255\n";
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < 3; k++) {
            float light = 0.125F;
            if (voxels[i] != VOXDAG_NONE) {
                VoxdagMaterial material;
                call(voxdag_scene_material, scene.get(), ids[i], &material);
                light = material.diffuse[k] * (1 + normals[3 * i + 1]);
            }
            picture.put(static_cast<char>(static_cast<unsigned char>(255 * light)));
        }
    }
    if (!picture.flush()) throw std::runtime_error(std::string(argv[2]) + " cannot be written");
    std::cout << info.voxel_count << " voxels in " << info.word_count << " words\n";
    return 0;
} catch (const std::exception &error) {
    std::cerr << error.what() << '\n';
    return 1;
}
