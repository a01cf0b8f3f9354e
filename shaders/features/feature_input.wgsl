// feature_input: what the first layer of a network of features sums over: the 3x3 pixels around each, less the mean of the image, in
//   32nds of its deviation. So that layer is one of points, with twelve channels, of which the last three are 0.
// image (u8 or u16, in a texture), statistics (u32: mean, deviation) -> values ([block of four channels][row][vector] as the layers
//   read them, from row first_row on)
// One invocation: four columns of a row.
// Border: rows and columns are clamped into the image.
// With: quotients, gray_pixels, bytes, common
// Reference: src/reference/features/feature_layer.rs, src/reference/features/feature_statistics.rs

@group(0) @binding(3) var<storage, read> statistics: array<u32>;
@group(0) @binding(4) var<storage, read_write> result: array<vec4<u32>>;

// The low bytes of four pixels, less the mean.
fn relative(pixels: vec4<i32>) -> vec4<u32> {
    let deep = select(256 * pixels, pixels, vec4(DEEP == 1u));
    let excess = deep - vec4(i32(statistics[0]));
    let deviation = vec4(statistics[1]);
    let size = min(quotients(16u * vec4<u32>(abs(excess)) + deviation, 2u * deviation), vec4(127u));
    return select(size, ~size + vec4(1u), excess < vec4(0)) & vec4(255u);
}

// Three pixels side by side around each of four.
struct Line {
    before: vec4<u32>,
    here: vec4<u32>,
    after: vec4<u32>,
}

fn line_at(x: i32, y: i32) -> Line {
    var pixels = pixels_from(x - 1, y);
    let a = relative(pixels[0]);
    let b = relative(pixels[1]);
    return Line(a, vec4(a.yzw, b.x), vec4(a.zw, b.xy));
}

fn words(a: vec4<u32>, b: vec4<u32>, c: vec4<u32>, d: vec4<u32>) -> vec4<u32> {
    return a | (b << vec4(8u)) | (c << vec4(16u)) | (d << vec4(24u));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let vectors = (frame.width + 3u) / 4u;
    if id.x >= vectors || id.y >= dispatch.rows {
        return;
    }
    let x = i32(4u * id.x);
    let y = i32(dispatch.first_row + id.y);
    let above = line_at(x, y - 1);
    let here = line_at(x, y);
    let below = line_at(x, y + 1);
    let stride = dispatch.rows * vectors;
    let at = id.y * vectors + id.x;
    result[at] = words(above.before, above.here, above.after, here.before);
    result[at + stride] = words(here.here, here.after, below.before, below.here);
    result[at + 2u * stride] = below.after;
}
