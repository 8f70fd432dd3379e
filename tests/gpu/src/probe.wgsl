// What the tests ask the shader: a question and an answer of 16 words each.

@group(1) @binding(0) var<storage, read> questions: array<u32>;
@group(1) @binding(1) var<storage, read_write> answers: array<u32>;

fn float_at(at: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(vec3(questions[at], questions[at + 1u], questions[at + 2u]));
}

fn put(at: u32, words: vec3<u32>) {
    answers[at] = words.x;
    answers[at + 1u] = words.y;
    answers[at + 2u] = words.z;
}

// Origin, direction, start, t_max -> flags (found, occluded), voxel, before, t, face, material, normal.
@compute @workgroup_size(64)
fn ask_rays(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = 16u * id.x;
    if at >= arrayLength(&questions) {
        return;
    }
    var query = vd_query(float_at(at), float_at(at + 3u));
    query.start = vec3<i32>(vec3(questions[at + 6u], questions[at + 7u], questions[at + 8u]));
    query.t_max = bitcast<f32>(questions[at + 9u]);
    let hit = vd_trace(query);
    answers[at] = u32(hit.found) | (u32(vd_occluded(query)) << 1u);
    put(at + 1u, hit.voxel);
    put(at + 4u, vec3<u32>(hit.before));
    answers[at + 7u] = bitcast<u32>(hit.t);
    answers[at + 8u] = hit.face;
    if hit.found {
        answers[at + 9u] = vd_material(hit.voxel);
        put(at + 10u, bitcast<vec3<u32>>(vd_normal(hit, query.dir)));
    }
}

// A voxel -> whether it is filled, its material.
@compute @workgroup_size(64)
fn ask_voxels(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = 16u * id.x;
    if at >= arrayLength(&questions) {
        return;
    }
    let voxel = vec3(questions[at], questions[at + 1u], questions[at + 2u]);
    answers[at] = u32(vd_contains(vec3<i32>(voxel)));
    answers[at + 1u] = vd_material(voxel);
}
