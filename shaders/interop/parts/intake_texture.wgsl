// Appended to `intake` where the pixels are a texture's. The samples are the bytes that it stores.
@group(0) @binding(3) var image: texture_2d<f32>;

// Back to what an sRGB texture stores, by the transfer function of IEC 61966-2-1. A step of the stored byte is 1 / 255,
// so the error of `pow`, below 1e-5, never reaches the nearest one.
fn stored(linear: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(linear, vec3(1.0 / 2.4)) - vec3(0.055);
    return select(curve, 12.92 * linear, linear <= vec3(0.0031308));
}

fn samples(values: vec4<f32>, largest: f32) -> vec4<u32> {
    return vec4<u32>(values * largest + vec4(0.5));
}

fn unit_at(x: u32, y: u32) -> u32 {
    let values = textureLoad(image, vec2(x / UNITS_A_PIXEL + dispatch.own.x, y + dispatch.own.y), 0);
    switch FORMAT {
        case GRAY8: {
            return samples(values, 255.0).x;
        }
        case GRAY16: {
            return samples(values, 65535.0).x;
        }
        case RGBA8: {
            let color = select(values.rgb, stored(values.rgb), vec3(SRGB == 1u));
            return pack(samples(vec4(color, values.a), 255.0));
        }
        default: {
            let deep = samples(values, 65535.0);
            let two = select(deep.xy, deep.zw, vec2((x & 1u) == 1u));
            return two.x | (two.y << 16u);
        }
    }
}
