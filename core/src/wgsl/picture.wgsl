// An example of a host's own shader: a picture by Phong's model, one ray a pixel. Goes behind the other parts.

struct VdPicture {
    // In grid coordinates: the eye, and the direction through the pixel of column x and row y is corner + x dx + y dy.
    eye: vec3<f32>,
    width: u32,
    corner: vec3<f32>,
    height: u32,
    dx: vec3<f32>,
    // The material's ambient colour counts this much.
    ambient: f32,
    dy: vec3<f32>,
    // A white light, in grid coordinates; linear colour where there is nothing.
    light: vec3<f32>,
    background: vec3<f32>,
}

@group(1) @binding(0) var<uniform> vd_picture: VdPicture;
// A word a pixel: red in the lowest byte, then green, blue, 255.
@group(1) @binding(1) var<storage, read_write> vd_pixels: array<u32>;

@compute @workgroup_size(8, 8)
fn vd_draw(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= vd_picture.width || id.y >= vd_picture.height {
        return;
    }
    let place = vec2<f32>(id.xy) + vec2(0.5);
    let dir = vd_picture.corner + place.x * vd_picture.dx + place.y * vd_picture.dy;
    let hit = vd_trace(vd_query(vd_picture.eye, dir));
    var color = vd_picture.background;
    if hit.found {
        color = vd_phong(hit, dir);
    }
    vd_pixels[id.y * vd_picture.width + id.x] = pack4x8unorm(vec4(vd_srgb(color), 1.0));
}

fn vd_phong(hit: VdHit, dir: vec3<f32>) -> vec3<f32> {
    // A record: ambient, diffuse, specular, three floats each; at word 17 the shininess, at 18 the model.
    let record = vd_scene.materials + 20u * min(vd_material(hit.voxel), vd_scene.material_count - 1u);
    let n = vd_normal(hit, dir);
    let to_viewer = -vd_unit(dir);
    let to_light = vd_unit(vd_picture.light - (vd_picture.eye + hit.t * dir));
    var color = vd_picture.ambient * vd_color(record);
    let cosine = dot(to_light, n);
    if cosine > 0.0 {
        color += cosine * vd_color(record + 3u);
        let mirrored = 2.0 * cosine * dot(to_viewer, n) - dot(to_viewer, to_light);
        if mirrored > 0.0 && (vd_words[record + 18u] & 255u) >= 2u {
            color += pow(min(mirrored, 1.0), f32(vd_words[record + 17u])) * vd_color(record + 6u);
        }
    }
    return color;
}

fn vd_color(at: u32) -> vec3<f32> {
    return vec3(bitcast<f32>(vd_words[at]), bitcast<f32>(vd_words[at + 1u]), bitcast<f32>(vd_words[at + 2u]));
}

// Linear light as sRGB.
fn vd_srgb(linear: vec3<f32>) -> vec3<f32> {
    let c = clamp(linear, vec3(0.0), vec3(1.0));
    return select(1.055 * pow(c, vec3(1.0 / 2.4)) - vec3(0.055), 12.92 * c, c <= vec3(0.0031308));
}
