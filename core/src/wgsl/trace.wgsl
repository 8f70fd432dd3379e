// The first filled voxel along the real line that six f32 describe: exactly, in 32-bit integers.
//
// A corner k of the lattice lies to one side of the line or the other: E = (k - o) x d, and the sign of its z says
// whether the line crosses the plane x = k.x before y = k.y, and so on. E = k x d + m, where m = d x o is the same for
// all corners (the line's Pluecker coordinates are d and m). All decisions are such signs. Origin and direction become
// 64-bit integers, their units powers of two, m takes 128 bits, and f32 decides wherever it is further from 0 than its
// error.
//
// The ray is mirrored so that it runs towards +x, +y, +z. It goes from empty cube to empty cube of the octree; how far
// it is on the other axes when it enters one is asked only as deep as the octree goes there (as Laine and Karras do,
// 2010). Of planes that are crossed at one time those in positive direction come first, together, then those in
// negative direction, together.

const VD_FOREVER: f32 = 3.4028234e38;

// The side of entry. (A hit's normal is vd_face_normal.)
const VD_NEG_X: u32 = 0u;
const VD_POS_X: u32 = 1u;
const VD_NEG_Y: u32 = 2u;
const VD_POS_Y: u32 = 3u;
const VD_NEG_Z: u32 = 4u;
const VD_POS_Z: u32 = 5u;
const VD_INSIDE: u32 = 6u;

struct VdQuery {
    // In grid coordinates: voxel k spans k to k + 1.
    origin: vec3<f32>,
    // Of any length; t is measured in units of it.
    dir: vec3<f32>,
    // Hits at or after it do not count.
    t_max: f32,
    // Starts in this empty voxel instead of where the origin lies, as rays do that leave a surface (VdHit.before); x is
    // below 0 for none.
    start: vec3<i32>,
}

struct VdHit {
    found: bool,
    voxel: vec3<u32>,
    // The last empty voxel before it; x is -1 if the ray starts in the hit or comes from outside the cube.
    before: vec3<i32>,
    // Entry, rounded; 0 if the ray starts inside.
    t: f32,
    face: u32,
}

// The half line from origin along dir.
fn vd_query(origin: vec3<f32>, dir: vec3<f32>) -> VdQuery {
    return VdQuery(origin, dir, VD_FOREVER, vec3(-1));
}

// The first filled voxel that the ray meets.
fn vd_trace(query: VdQuery) -> VdHit {
    var hit = VdHit(false, vec3(0u), vec3(-1), 0.0, VD_INSIDE);
    var ray = vd_begin(query);
    if !vd_walk(&ray) {
        return hit;
    }
    hit.found = true;
    let last = (1u << max(vd_scene.depth, 2u)) - 1u;
    hit.voxel = select(ray.p, vec3(last) - ray.p, ray.negative);
    if !any(ray.entered) {
        return hit;
    }

    // The ray came in through the planes that it crossed last; the steepest of them gives the face.
    let order = vd_sides(&ray, ray.p);
    let crossed = (order.zxy >= vec3(0)) & (order.yzx <= vec3(0)) & ray.moves;
    // Sizes of floats are in the order of their bits.
    let sizes = bitcast<vec3<i32>>(query.dir) & vec3(0x7fffffff);
    let steep = select(vec3(-1), sizes, crossed);
    let axis = select(select(2u, 1u, steep.y >= steep.z), 0u, steep.x >= steep.y && steep.x >= steep.z);
    hit.face = 2u * axis + u32(ray.negative[axis]);
    hit.t = max(vd_time(&ray, ray.p, vec3<u32>(0u, 1u, 2u) == vec3(axis)), 0.0);
    let step = select(vec3(0), select(vec3(-1), vec3(1), ray.negative), crossed);
    let before = vec3<i32>(hit.voxel) + step;
    if all(before >= vec3(0)) && all(before < vec3(1i << vd_scene.depth)) {
        hit.before = before;
    }
    return hit;
}

// Whether the ray meets any filled voxel.
fn vd_occluded(query: VdQuery) -> bool {
    var ray = vd_begin(query);
    return vd_walk(&ray);
}

// The outward normal of a side; 0 for VD_INSIDE.
fn vd_face_normal(face: u32) -> vec3<f32> {
    let side = select(-1.0, 1.0, (face & 1u) != 0u);
    return select(vec3(0.0), vec3(side), vec3<u32>(0u, 1u, 2u) == vec3(face >> 1u));
}

// A ray, and where it is. All but the query is mirrored: where it runs in negative direction, k stands for 2^L - k.
struct VdRay {
    query: VdQuery,
    // Along which axes it moves at all, and in negative direction.
    moves: vec3<bool>,
    negative: vec3<bool>,
    // |d| times a power of two that makes the largest component 2^62 to 2^63: low and high words.
    dir_low: vec3<u32>,
    dir_high: vec3<u32>,
    // m = d x o by components, 128 bits; a unit is 2^-32 voxels times one of |d|.
    moment_x: vec4<u32>,
    moment_y: vec4<u32>,
    moment_z: vec4<u32>,
    // Both as f32, in units of 2^62 of |d|.
    dir: vec3<f32>,
    moment: vec3<f32>,
    // The order of planes that are crossed at one time.
    tie: vec3<i32>,
    // The corner of the cube that it is in, and the level of the cube; above the root's if it meets nothing.
    p: vec3<u32>,
    level: u32,
    // One of the axes whose planes through p were crossed when it came in; none at the start.
    entered: vec3<bool>,
}

// The query's ray in its first place.
fn vd_begin(query: VdQuery) -> VdRay {
    var ray: VdRay;
    ray.query = query;
    ray.level = 32u;
    let size = 1u << max(vd_scene.depth, 2u);
    let origin = vd_floats(query.origin);
    let dir = vd_floats(query.dir);
    ray.moves = dir.mantissa != vec3(0u);
    if !origin.finite || !dir.finite || !any(ray.moves) {
        return ray;
    }
    ray.negative = dir.below & ray.moves;
    let later = vec3<i32>(ray.negative);
    ray.tie = later.yzx - later.zxy;

    // The direction in 63 bits.
    let dir_by = max(dir.exponent + vec3(62 - dir.top), vec3(-63));
    let dx = vd_place(dir.mantissa.x, dir_by.x);
    let dy = vd_place(dir.mantissa.y, dir_by.y);
    let dz = vd_place(dir.mantissa.z, dir_by.z);
    ray.dir_low = vec3(dx.x, dy.x, dz.x);
    ray.dir_high = vec3(dx.y, dy.y, dz.y);
    ray.dir = vec3<f32>(ray.dir_high) * 0x1p-30f;

    // The origin below 2^62, in units of 2^-32 voxels, or of more the farther away it is; mirrored.
    let unit = min(61 - origin.top, 32);
    if unit < 0 {
        return ray;
    }
    let origin_by = max(origin.exponent + vec3(unit), vec3(-63));
    let side = vd_place(size, unit);
    let ox = vd_mirror(vd_place(origin.mantissa.x, origin_by.x), origin.below.x, ray.negative.x, side);
    let oy = vd_mirror(vd_place(origin.mantissa.y, origin_by.y), origin.below.y, ray.negative.y, side);
    let oz = vd_mirror(vd_place(origin.mantissa.z, origin_by.z), origin.below.z, ray.negative.z, side);

    // The moment; a line on which it does not fit is far from the cube.
    let up = u32(32 - unit);
    let mx = vd_moment(vd_add(vd_product(oz, dy), vd_negate(vd_product(oy, dz))), up);
    let my = vd_moment(vd_add(vd_product(ox, dz), vd_negate(vd_product(oz, dx))), up);
    let mz = vd_moment(vd_add(vd_product(oy, dx), vd_negate(vd_product(ox, dy))), up);
    if !(mx.fits && my.fits && mz.fits) {
        return ray;
    }
    ray.moment_x = mx.value;
    ray.moment_y = my.value;
    ray.moment_z = mz.value;
    let high = bitcast<vec3<i32>>(vec3(mx.value.w, my.value.w, mz.value.w));
    ray.moment = vec3<f32>(high) * 4.0 + vec3<f32>(vec3(mx.value.z, my.value.z, mz.value.z)) * 0x1p-30f;
    vd_enter(&ray, size);
    return ray;
}

// Puts a ray in its first voxel, or in the cube as a whole, if it meets that.
fn vd_enter(ray: ptr<function, VdRay>, size: u32) {
    // The voxel asked for, or the origin's. Beyond the cube there is none to be met.
    let query = (*ray).query;
    let negative = (*ray).negative;
    if !(query.t_max > 0.0) {
        return;
    }
    if query.start.x >= 0 {
        let start = vec3<u32>(query.start);
        if all(start < vec3(size)) {
            (*ray).p = select(start, vec3(size - 1u) - start, negative);
            (*ray).level = 0u;
        }
        return;
    }
    let cell = vec3<i32>(clamp(floor(query.origin), vec3(-1.0), vec3(f32(size))));
    let first = select(cell, vec3(i32(size) - 1) - cell, negative);
    let outside = first < vec3(0);
    if any(first >= vec3(i32(size))) || any(outside & !(*ray).moves) {
        return;
    }
    if !any(outside) {
        (*ray).p = vec3<u32>(first);
        (*ray).level = 0u;
        return;
    }

    // It comes in through the last of the cube's planes that face it, if that is before the first of the others.
    let order = vd_sides(ray, vec3(0u));
    let last = outside & (!outside.yzx | (order.zxy >= vec3(0))) & (!outside.zxy | (order.yzx <= vec3(0)));
    (*ray).entered = vd_one(last);
    if !any(vd_crossed(ray, size)) && !vd_ends(ray) {
        (*ray).level = firstLeadingBit(size);
    }
}

// The first of the axes that are true.
fn vd_one(axes: vec3<bool>) -> vec3<bool> {
    return vec3(axes.x, axes.y && !axes.x, axes.z && !(axes.x || axes.y));
}

// Of the planes x = k.x, y = k.y, z = k.z: is y crossed before z (-1), with it (0) or after it (1)? z and x? x and y?
fn vd_sides(ray: ptr<function, VdRay>, k: vec3<u32>) -> vec3<i32> {
    let dir = (*ray).dir;
    let place = vec3<f32>(k);
    let plus = place.yzx * dir.zxy;
    let minus = place.zxy * dir.yzx;
    let value = (*ray).moment + (plus - minus);
    // Five roundings, each by at most a unit in the last place, and what was cut off beforehand.
    let cut = max(max(place.x, place.y), place.z) * 0x1p-28f + 0x1p-20f;
    let slack = (abs((*ray).moment) + plus + minus) * 0x1.4p-21f + cut;
    var sides = vec3<i32>(sign(value));
    // Of two planes that the ray never comes to, neither is first.
    let moves = (*ray).moves;
    let close = (abs(value) <= slack) & (moves.yzx | moves.zxy);
    if any(close) {
        let dx = vec2((*ray).dir_low.x, (*ray).dir_high.x);
        let dy = vec2((*ray).dir_low.y, (*ray).dir_high.y);
        let dz = vec2((*ray).dir_low.z, (*ray).dir_high.z);
        if close.x {
            sides.x = vd_side((*ray).moment_x, k.y, dz, k.z, dy, (*ray).tie.x);
        }
        if close.y {
            sides.y = vd_side((*ray).moment_y, k.z, dx, k.x, dz, (*ray).tie.y);
        }
        if close.z {
            sides.z = vd_side((*ray).moment_z, k.x, dy, k.y, dx, (*ray).tie.z);
        }
    }
    return sides;
}

// Whether the planes half a cube further on are crossed by the time the ray came in.
fn vd_crossed(ray: ptr<function, VdRay>, half: u32) -> vec3<bool> {
    let entered = (*ray).entered;
    let order = vd_sides(ray, (*ray).p + select(vec3(half), vec3(0u), entered));
    return (entered.zxy & (order.yzx >= vec3(0))) | (entered.yzx & (order.zxy <= vec3(0)));
}

// When the ray crosses the plane through k of one axis, rounded.
fn vd_time(ray: ptr<function, VdRay>, k: vec3<u32>, axis: vec3<bool>) -> f32 {
    let size = 1u << max(vd_scene.depth, 2u);
    let plane = vec3<f32>(select(k, vec3(size) - k, (*ray).negative));
    let way = dot(select(vec3(0.0), plane - (*ray).query.origin, axis), vec3(1.0));
    return way / dot(select(vec3(0.0), (*ray).query.dir, axis), vec3(1.0));
}

// Whether it came in at t_max or later.
fn vd_ends(ray: ptr<function, VdRay>) -> bool {
    let t_max = (*ray).query.t_max;
    return t_max < VD_FOREVER && vd_time(ray, (*ray).p, (*ray).entered) >= t_max;
}

// Goes on to the first filled voxel; false if there is none.
fn vd_walk(ray: ptr<function, VdRay>) -> bool {
    let top = max(vd_scene.depth, 2u);
    if vd_scene.root == 0u || (*ray).level > top {
        return false;
    }
    let size = 1u << top;
    let mirror = vec3<u32>((*ray).negative);
    // What was found on the way down: offsets of nodes and of a brick, and at level 1 the bits of 2^3 voxels.
    var nodes: array<u32, 22>;
    var level = top;
    var node = vd_scene.root;
    nodes[level] = node;

    // Each plane is crossed once, and gone down behind at most as deep as it lies: no ray takes more steps than this.
    let most = 9u * size + 32u;
    for (var i = 0u; i < most; i++) {
        // In which half of the node's cube is the ray, on each axis?
        let half = 1u << (level - 1u);
        if (*ray).level == level {
            (*ray).p += select(vec3(0u), vec3(half), vd_crossed(ray, half));
            (*ray).level = level - 1u;
        }
        let bits = (((*ray).p >> vec3(level - 1u)) & vec3(1u)) ^ mirror;
        let octant = bits.x | (bits.y << 1u) | (bits.z << 2u);

        // What is there?
        var child = 0u;
        if level > 2u {
            let at = vd_scene.dag + node;
            let mask = vd_words[at];
            if ((mask >> octant) & 1u) != 0u {
                child = vd_words[at + 1u + countOneBits(mask & ((1u << octant) - 1u))];
            }
        } else if level == 2u {
            child = (vd_words[vd_scene.dag + node + (octant >> 2u)] >> (8u * (octant & 3u))) & 255u;
        } else {
            child = (node >> octant) & 1u;
        }
        if child != 0u {
            if level == 1u {
                return true;
            }
            level -= 1u;
            node = child;
            nodes[level] = node;
            continue;
        }

        // Leave the empty cube through the planes that come first.
        let corner = (*ray).p & vec3(~(half - 1u));
        let far = corner + vec3(half);
        let order = vd_sides(ray, far);
        let first = (order.zxy <= vec3(0)) & (order.yzx >= vec3(0));
        let next = select(corner, far, first);
        (*ray).entered = vd_one(first);
        (*ray).p = next;
        (*ray).level = level - 1u;
        if ((next.x | next.y | next.z) & size) != 0u {
            return false;
        }
        if vd_ends(ray) {
            return false;
        }
        // The smallest cube that holds both is still known.
        let changed = corner ^ next;
        level = firstLeadingBit(changed.x | changed.y | changed.z) + 1u;
        node = nodes[level];
    }
    return false;
}
