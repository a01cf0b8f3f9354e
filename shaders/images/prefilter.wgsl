// prefilter: xsobel clamp(gx, -cap, cap) + cap; sobel min(floor(sqrt(gx^2 + gy^2)), 2 cap); normalized the smoothed pixel
//   less the mean of the window around it, times 4, clamped and shifted like xsobel; none: the value, in 8 bits. With
//   OPENCV_RULES the border and the quotient of OpenCV's StereoBM.
// image (u8 or u16, in a texture), sums (u32, [y][x], of the windows) -> plane (u8, sixteen pixels a vector, continued by
//   the border)
//   Byte j of a row is column j - lead, or if it is mirrored column lead - j: rising disparities then lie at rising
//   addresses.
// One invocation: one vector of a row of the plane. Border: rows are clamped into the image, columns are continued.
// With: root, gray_pixels, plane_layout, bytes, common
// Reference: src/reference/images/prefilter.rs

@group(0) @binding(3) var<storage, read> sums: array<u32>;
@group(0) @binding(4) var<storage, read_write> plane: array<vec4<u32>>;

fn roots(n: vec4<i32>) -> vec4<i32> {
    let m = vec4<u32>(n);
    return vec4<i32>(vec4(integer_root(m.x), integer_root(m.y), integer_root(m.z), integer_root(m.w)));
}

// 4 (smoothed pixel - mean of the window), rounded down, of four pixels from column x on.
fn response(above: Pixels, here: Pixels, below: Pixels, i: u32, x: i32, y: i32) -> vec4<i32> {
    let centre = vec4(here[i].yzw, here[i + 1u].x);
    let beside = here[i] + vec4(here[i].zw, here[i + 1u].xy);
    let smoothed = 4 * centre + beside + vec4(above[i].yzw, above[i + 1u].x) + vec4(below[i].yzw, below[i + 1u].x);
    if OPENCV_RULES == 1u {
        return mean_in_levels(i32(NORMALIZED_SCALE) * (i32(NORMALIZED_EIGHTH) * smoothed - sums_at(x, y)), 1024);
    }
    let n = i32(PREFILTER_WINDOW * PREFILTER_WINDOW);
    return mean_in_levels(n * smoothed - 8 * sums_at(x, y), 2 * n);
}

fn sums_at(x: i32, y: i32) -> vec4<i32> {
    let columns = vec4<u32>(clamp(vec4(x) + vec4(0, 1, 2, 3), vec4(0), vec4(i32(frame.width) - 1)));
    let at = vec4(u32(y) * frame.width) + columns;
    return vec4<i32>(vec4(sums[at.x], sums[at.y], sums[at.z], sums[at.w]));
}

// Where StereoBM has no derivative, of four pixels from column x on: in the first and the last column, and in the last one
// of an odd number of rows.
fn at_border(x: i32, y: i32) -> vec4<bool> {
    let columns = vec4(x) + vec4(0, 1, 2, 3);
    let last = y == i32(frame.height) - 1 && (frame.height & 1u) == 1u;
    return (columns == vec4(0)) | (columns == vec4(i32(frame.width) - 1)) | vec4(last);
}

// Four pixels, from column x + 4 i on: those in the middle of columns k .. k + 2 of the rows, k = 4 i .. 4 i + 3.
fn filtered(above: Pixels, here: Pixels, below: Pixels, i: u32, x: i32, y: i32) -> u32 {
    if PREFILTER == PREFILTER_NONE {
        return pack(vec4<u32>(in_levels(vec4(here[i].yzw, here[i + 1u].x))));
    }
    let cap = vec4(i32(frame.prefilter_cap));
    if PREFILTER == PREFILTER_NORMALIZED {
        return pack(vec4<u32>(clamp(response(above, here, below, i, x + i32(4u * i), y), -cap, cap) + cap));
    }
    var gx = sobel_x(above, here, below, i);
    if PREFILTER == PREFILTER_XSOBEL {
        if OPENCV_RULES == 1u {
            gx = select(gx, vec4(0), at_border(x + i32(4u * i), y));
        }
        return pack(vec4<u32>(clamp(gx, -cap, cap) + cap));
    }
    let gy = sobel_y(above, below, i);
    return pack(vec4<u32>(min(roots(gx * gx + gy * gy), 2 * cap)));
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let mirrored = dispatch.own.mirrored == 1u;
    let stride = dispatch.stride / 4u;
    if id.x >= stride || id.y >= dispatch.rows {
        return;
    }
    let x = lowest_column(id.x, mirrored);
    let y = i32(dispatch.first_row + id.y);
    var rows = vec2(y - 1, y + 1);
    if OPENCV_RULES == 1u && PREFILTER == PREFILTER_XSOBEL {
        // Rows outside the image are those as far inside.
        let last = i32(frame.height) - 1;
        rows = vec2(abs(y - 1), last - abs(last - y - 1));
    }
    let above = pixels_from(x - 1, rows.x);
    let here = pixels_from(x - 1, y);
    let below = pixels_from(x - 1, rows.y);
    let words = vec4(filtered(above, here, below, 0u, x, y), filtered(above, here, below, 1u, x, y),
        filtered(above, here, below, 2u, x, y), filtered(above, here, below, 3u, x, y));
    plane[(dispatch.own.first_plane * dispatch.rows + id.y) * stride + id.x] = laid_out(words, x, mirrored);
}
