// The surface's direction at a hit: the plane through the 5^3 voxels around (voxdag::normal, NormalKind::Plane2).
//
// The same cases as there, decided by the same integers as far as they fit 32 bits; the smallest eigenvalue and what
// follows from it are f32.

// The unit normal at a hit of a ray along dir (of any length); a unit vector, whatever is asked.
fn vd_normal(hit: VdHit, dir: vec3<f32>) -> vec3<f32> {
    let view = vd_unit(dir);
    var face = vd_face_normal(hit.face);
    if hit.face == VD_INSIDE {
        // Against the largest component of the direction.
        let a = abs(dir);
        let axis = select(select(2u, 1u, a.y >= a.z), 0u, a.x >= a.y && a.x >= a.z);
        face = vd_face_normal(2u * axis + u32(dir[axis] <= 0.0));
    }
    let window = vd_window(vec3<i32>(hit.voxel));
    let normal = vd_fit(window, view, face);
    return select(face, normal, any(normal != vec3(0.0)));
}

// The filled voxels among the 5^3 around one, by their places -2 to 2 from it.
struct VdWindow {
    count: i32,
    // Sums of x, y, z, of xx, yy, zz, and of yz, zx, xy.
    first: vec3<i32>,
    squares: vec3<i32>,
    products: vec3<i32>,
    // From filled to empty among the six neighbours.
    gradient: vec3<i32>,
}

// The voxels of a brick with coordinate `at` (0 to 4) or more on an axis.
fn vd_from(axis: u32, at: u32) -> vec2<u32> {
    // Those with the axis's low and high bit, by the Morton order.
    let low = array<u32, 3>(0xaaaaaaaau, 0xccccccccu, 0xf0f0f0f0u)[axis];
    let high = array<vec2<u32>, 3>(vec2(0xff00ff00u), vec2(0xffff0000u), vec2(0u, 0xffffffffu))[axis];
    switch at {
        case 0u: { return vec2(0xffffffffu); }
        case 1u: { return high | vec2(low); }
        case 2u: { return high; }
        case 3u: { return high & vec2(low); }
        default: { return vec2(0u); }
    }
}

// The voxels of the window along an axis that lie in its first brick, which they enter at `at`, or in the next one.
fn vd_part(axis: u32, at: u32, next: u32) -> vec2<u32> {
    return select(vd_from(axis, at), ~vd_from(axis, at + 1u), next != 0u);
}

fn vd_window(center: vec3<i32>) -> VdWindow {
    var window: VdWindow;
    // Five voxels are some of one brick and some of the next, on every axis.
    let corner = center - vec3(2);
    let at = vec3<u32>(corner) & vec3(3u);
    for (var i = 0u; i < 8u; i++) {
        let next = vec3<u32>(i & 1u, (i >> 1u) & 1u, i >> 2u);
        let first = (corner & vec3(-4)) + vec3<i32>(4u * next);
        let part = vd_part(0u, at.x, next.x) & vd_part(1u, at.y, next.y) & vd_part(2u, at.z, next.z);
        let brick = vd_brick(first) & part;
        for (var word = 0u; word < 2u; word++) {
            for (var left = brick[word]; left != 0u; left &= left - 1u) {
                let bit = countTrailingZeros(left) + 32u * word;
                let axes = vec3(bit) >> vec3(0u, 1u, 2u);
                let place = (axes & vec3(1u)) | ((axes >> vec3(2u)) & vec3(2u));
                let r = first + vec3<i32>(place) - center;
                window.count += 1;
                window.first += r;
                window.squares += r * r;
                window.products += r.yzx * r.zxy;
                window.gradient -= select(vec3(0), r, dot(r, r) == 1);
            }
        }
    }
    return window;
}

// The normal that fits a window, turned out of the surface; 0 if none does.
fn vd_fit(window: VdWindow, view: vec3<f32>, face: vec3<f32>) -> vec3<f32> {
    // Their covariance times count^2, and its adjugate: diagonal, and the others by the axis that is missing.
    let n = window.count;
    let s = window.first;
    let d = n * window.squares - s * s;
    let o = n * window.products - s.yzx * s.zxy;
    let adj_d = d.yzx * d.zxy - o * o;
    let adj_o = o.yzx * o.zxy - o * d;
    if all(d == vec3(0)) {
        return vec3(0.0);
    }
    let diagonal = vec3<f32>(d);
    let mixed = vec3<f32>(o);
    if all(adj_d == vec3(0)) {
        // On a line: the way to the viewer, made perpendicular to it.
        let line = vd_column(diagonal, mixed);
        return vd_outwards(vd_unit(cross(line, cross(view, line))), -view);
    }

    // The smallest eigenvalue, by Newton's method from 0, and the next one.
    let t = diagonal.x + diagonal.y + diagonal.z;
    let adj_diagonal = vec3<f32>(adj_d);
    let adj_mixed = vec3<f32>(adj_o);
    let e2 = adj_diagonal.x + adj_diagonal.y + adj_diagonal.z;
    let e3 = diagonal.x * adj_diagonal.x + mixed.z * adj_mixed.z + mixed.y * adj_mixed.y;
    var l0 = 0.0;
    for (var i = 0; i < 8; i++) {
        let slope = (3.0 * l0 - 2.0 * t) * l0 + e2;
        let step = (e3 - ((l0 - t) * l0 + e2) * l0) / slope;
        if !(slope > 0.0 && step > 0.0) {
            break;
        }
        l0 += step;
        if step < 1e-4 * l0 {
            break;
        }
    }
    let sum = t - l0;
    let product = e2 - l0 * sum;
    let l1 = 2.0 * product / (sum + sqrt(max(sum * sum - 4.0 * product, 0.0)));
    if l0 > 0.6 * l1 {
        return vd_outwards(vec3<f32>(window.gradient), face - view);
    }
    let normal = vd_column(adj_diagonal + l0 * (diagonal - vec3(t)) + vec3(l0 * l0), adj_mixed + l0 * mixed);
    return vd_outwards(normal, face - view - vec3<f32>(s) / f32(n));
}

// The column of a symmetric matrix of rank one that has the largest diagonal entry.
fn vd_column(d: vec3<f32>, o: vec3<f32>) -> vec3<f32> {
    if d.x >= d.y && d.x >= d.z {
        return vec3(d.x, o.z, o.y);
    }
    if d.y >= d.z {
        return vec3(o.z, d.y, o.x);
    }
    return vec3(o.y, o.x, d.z);
}

// At unit length, on the side of `outwards`; 0 if that is at right angles to it.
fn vd_outwards(normal: vec3<f32>, outwards: vec3<f32>) -> vec3<f32> {
    let unit = vd_unit(normal);
    return unit * sign(dot(unit, outwards));
}

// At unit length; 0 stays 0.
fn vd_unit(v: vec3<f32>) -> vec3<f32> {
    let largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if !(largest > 0.0) {
        return vec3(0.0);
    }
    let scaled = v / largest;
    return scaled / sqrt(dot(scaled, scaled));
}
