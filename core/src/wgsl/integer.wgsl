// Integers of 64 and 128 bits, low words first, that wrap around: what decides where f32 cannot.

fn vd_multiply(a: u32, b: u32) -> vec2<u32> {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let middle = a1 * b0 + ((a0 * b0) >> 16u);
    let rest = a0 * b1 + (middle & 0xffffu);
    return vec2(a * b, a1 * b1 + (middle >> 16u) + (rest >> 16u));
}

fn vd_add(a: vec4<u32>, b: vec4<u32>) -> vec4<u32> {
    let x = a.x + b.x;
    let y = a.y + b.y;
    let z = a.z + b.z;
    let carry_y = u32(x < a.x);
    let carry_z = u32(y < a.y) | u32(y + carry_y < y);
    let carry_w = u32(z < a.z) | u32(z + carry_z < z);
    return vec4(x, y + carry_y, z + carry_z, a.w + b.w + carry_w);
}

fn vd_negate(a: vec4<u32>) -> vec4<u32> {
    return vd_add(~a, vec4(1u, 0u, 0u, 0u));
}

// A signed number of 64 bits times one of 63.
fn vd_product(a: vec2<u32>, b: vec2<u32>) -> vec4<u32> {
    let low = vd_multiply(a.x, b.x);
    let left = vd_multiply(a.x, b.y);
    let right = vd_multiply(a.y, b.x);
    let high = vd_multiply(a.y, b.y);
    var sum = vd_add(vec4(low, high), vec4(0u, left, 0u));
    sum = vd_add(sum, vec4(0u, right, 0u));
    if (a.y >> 31u) != 0u {
        sum = vd_add(sum, vd_negate(vec4(0u, 0u, b)));
    }
    return sum;
}

// a << by for 0 to 31.
fn vd_shift(a: vec4<u32>, by: u32) -> vec4<u32> {
    if by == 0u {
        return a;
    }
    let carry = a >> vec4(32u - by);
    return (a << vec4(by)) | vec4(0u, carry.x, carry.y, carry.z);
}

// Three floats taken apart: mantissa * 2^exponent. The largest is at least 2^top and below 2^(top + 1).
struct VdFloats {
    mantissa: vec3<u32>,
    exponent: vec3<i32>,
    below: vec3<bool>,
    finite: bool,
    top: i32,
}

fn vd_floats(v: vec3<f32>) -> VdFloats {
    let bits = bitcast<vec3<u32>>(v);
    let exponent = (bits >> vec3(23u)) & vec3(255u);
    let whole = select(vec3(0u), vec3(0x800000u), exponent != vec3(0u));
    let mantissa = (bits & vec3(0x7fffffu)) | whole;
    let power = vec3<i32>(max(exponent, vec3(1u))) - vec3(150);
    let tops = power + firstLeadingBit(vec3<i32>(mantissa));
    let top = max(max(tops.x, tops.y), tops.z);
    return VdFloats(mantissa, power, (bits >> vec3(31u)) != vec3(0u), all(exponent != vec3(255u)), top);
}

// mantissa * 2^by in 64 bits, by -63 to 62; what would vanish is 1.
fn vd_place(mantissa: u32, by: i32) -> vec2<u32> {
    if mantissa == 0u {
        return vec2(0u);
    }
    if by < 0 {
        return vec2(max(select(mantissa >> (u32(-by) & 31u), 0u, by < -31), 1u), 0u);
    }
    let shifted = vd_shift(vec4(mantissa, 0u, 0u, 0u), u32(by) & 31u);
    return select(shifted.xy, vec2(0u, shifted.x), by > 31);
}

// A coordinate from its size and sign, mirrored in a cube of this side where the ray is.
fn vd_mirror(size: vec2<u32>, below: bool, negative: bool, side: vec2<u32>) -> vec2<u32> {
    let number = vec4(size, 0u, 0u);
    let start = select(vec4(0u), vec4(side, 0u, 0u), negative);
    return select(vd_add(start, vd_negate(number)), vd_add(start, number), below == negative).xy;
}

struct VdMoment {
    value: vec4<u32>,
    fits: bool,
}

// value << up for 0 to 32, and whether that is whole and below 2^126.
fn vd_moment(value: vec4<u32>, up: u32) -> VdMoment {
    let words = select(value, vec4(0u, value.xyz), up == 32u);
    let shifted = vd_shift(words, up & 31u);
    // What is shifted out must be nothing but copies of the sign.
    let back = bitcast<u32>(bitcast<i32>(shifted.w) >> (up & 31u));
    let top = bitcast<u32>(bitcast<i32>(back) >> 31u);
    let whole = back == words.w && (up < 32u || value.w == top);
    return VdMoment(shifted, whole && shifted.w + 0x40000000u < 0x80000000u);
}

// The sign of moment + k1 * d2 - k2 * d1, or what stands for 0.
fn vd_side(moment: vec4<u32>, k1: u32, d2: vec2<u32>, k2: u32, d1: vec2<u32>, tie: i32) -> i32 {
    let plus = vd_add(vec4(0u, vd_multiply(k1, d2.x), 0u), vec4(0u, 0u, vd_multiply(k1, d2.y)));
    let minus = vd_add(vec4(0u, vd_multiply(k2, d1.x), 0u), vec4(0u, 0u, vd_multiply(k2, d1.y)));
    let sum = vd_add(vd_add(moment, plus), vd_negate(minus));
    if all(sum == vec4(0u)) {
        return tie;
    }
    return select(1, -1, (sum.w >> 31u) != 0u);
}
