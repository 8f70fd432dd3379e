// Which material a voxel has, by the material tree (voxdag::tree, whose words it reads).

// The material id of a voxel in the cube; of an empty one that of some voxel nearby.
fn vd_material(voxel: vec3<u32>) -> u32 {
    let tree = vd_scene.tree;
    let root = max(vd_scene.depth, 2u);
    if tree == 0u || ((voxel.x | voxel.y | voxel.z) >> root) != 0u {
        return select(0u, vd_scene.material, tree == 0u);
    }
    let top = min(vd_words[tree + 1u], root);
    var level = root - top;
    let cell = voxel >> vec3(level);
    var entry = vd_words[tree + 28u + ((((cell.z << top) | cell.y) << top) | cell.x)];
    while (entry >> 29u) == 2u && level > 2u {
        level -= 1u;
        entry = vd_words[vd_scene.tree_nodes + 8u * (entry & 0x1fffffffu) + vd_octant(voxel, level)];
    }
    let kind = entry >> 29u;
    let value = entry & 0x1fffffffu;
    if kind == 0u {
        return value;
    }
    if kind == 1u {
        let ids = vd_words[vd_scene.tree_pairs + 2u * value];
        let second = vd_pair_bit(vd_words[vd_scene.tree_pairs + 2u * value + 1u], level, voxel);
        return (ids >> (16u * second)) & 0xffffu;
    }
    // A brick: ids, two a word, then for up to 4 or 16 of them which one each voxel has.
    let bit = vd_bit(voxel);
    var brick = vd_scene.tree_few + 6u * value;
    var index = (vd_words[brick + 2u + bit / 16u] >> (2u * (bit % 16u))) & 3u;
    if kind == 4u {
        brick = vd_scene.tree_some + 16u * value;
        index = (vd_words[brick + 8u + bit / 8u] >> (4u * (bit % 8u))) & 15u;
    } else if kind == 5u {
        brick = vd_scene.tree_many + 32u * value;
        index = bit;
    } else if kind != 3u {
        return 0u;
    }
    return (vd_words[brick + index / 2u] >> (16u * (index % 2u))) & 0xffffu;
}

// The octant of a cube of level + 1 in which a voxel is.
fn vd_octant(voxel: vec3<u32>, level: u32) -> u32 {
    let bits = (voxel >> vec3(level)) & vec3(1u);
    return bits.x | (bits.y << 1u) | (bits.z << 2u);
}

// Half i of a level's halves, which start at the first one.
fn vd_half(first: u32, i: u32) -> u32 {
    return (vd_words[vd_scene.tree_halves + (first + i) / 2u] >> (16u * ((first + i) % 2u))) & 0xffffu;
}

// Which of a pair's two a voxel is, in a cube of this level.
fn vd_pair_bit(start: u32, cube: u32, voxel: vec3<u32>) -> u32 {
    var swap = start >> 31u;
    var at = start & 0x7fffffffu;
    for (var level = cube; level > 2u;) {
        var first = 0u;
        if level > 3u {
            first = vd_words[vd_scene.tree + 4u + level];
        }
        let node = vd_half(first, at);
        level -= 1u;
        let octant = vd_octant(voxel, level);
        if ((node >> octant) & 1u) == 0u {
            return ((node >> (8u + octant)) & 1u) ^ swap;
        }
        let before = countOneBits(node & ((1u << octant) - 1u));
        if ((vd_scene.tree_wide >> level) & 1u) == 0u {
            let place = vd_half(first, at + 1u + before);
            swap ^= place >> 15u;
            at = place & 0x7fffu;
        } else {
            let place = vd_half(first, at + 1u + 2u * before) | (vd_half(first, at + 2u + 2u * before) << 16u);
            swap ^= place >> 31u;
            at = place & 0x7fffffffu;
        }
    }
    let bit = vd_bit(voxel);
    return ((vd_words[vd_scene.tree_patterns + 2u * at + bit / 32u] >> (bit % 32u)) & 1u) ^ swap;
}
