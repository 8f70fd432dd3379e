// What the host binds: the words of a .vxd file, or of its DAG alone, as they are, and where things lie in them.

// From voxdag::wgsl::scene or voxdag::wgsl::dag, word by word. Offsets count words from the start of vd_words.
struct VdScene {
    // The DAG's first word, its levels, and its root counted from that word; 0 if no voxel is filled.
    dag: u32,
    depth: u32,
    root: u32,
    // The first material's record of 20 words, and how many there are.
    materials: u32,
    material_count: u32,
    // The material of all voxels, unless there is a tree.
    material: u32,
    // The material tree's first word; 0 if there is none. Then its parts.
    tree: u32,
    tree_nodes: u32,
    tree_pairs: u32,
    tree_few: u32,
    tree_some: u32,
    tree_many: u32,
    tree_patterns: u32,
    tree_halves: u32,
    // Bit l: places of bits in level l take two halves.
    tree_wide: u32,
    reserved: u32,
}

@group(0) @binding(0) var<storage, read> vd_words: array<u32>;
@group(0) @binding(1) var<uniform> vd_scene: VdScene;

// The brick of 4^3 voxels, in Morton order, that holds a voxel; empty outside the cube.
fn vd_brick(voxel: vec3<i32>) -> vec2<u32> {
    let p = vec3<u32>(voxel);
    let top = max(vd_scene.depth, 2u);
    // Negative coordinates are far outside.
    if vd_scene.root == 0u || ((p.x | p.y | p.z) >> top) != 0u {
        return vec2(0u);
    }
    var node = vd_scene.dag + vd_scene.root;
    for (var level = top; level > 2u; level--) {
        let bits = (p >> vec3(level - 1u)) & vec3(1u);
        let octant = bits.x | (bits.y << 1u) | (bits.z << 2u);
        let mask = vd_words[node];
        if ((mask >> octant) & 1u) == 0u {
            return vec2(0u);
        }
        node = vd_scene.dag + vd_words[node + 1u + countOneBits(mask & ((1u << octant) - 1u))];
    }
    return vec2(vd_words[node], vd_words[node + 1u]);
}

// The number of a voxel in its brick.
fn vd_bit(voxel: vec3<u32>) -> u32 {
    let low = voxel & vec3(1u);
    let high = (voxel >> vec3(1u)) & vec3(1u);
    return low.x | (low.y << 1u) | (low.z << 2u) | (high.x << 3u) | (high.y << 4u) | (high.z << 5u);
}

// Whether a voxel is filled; voxels outside the cube are not.
fn vd_contains(voxel: vec3<i32>) -> bool {
    let brick = vd_brick(voxel);
    let bit = vd_bit(vec3<u32>(voxel));
    return ((select(brick.x, brick.y, bit >= 32u) >> (bit & 31u)) & 1u) != 0u;
}
