// mi_smooth: a table smoothed along one axis by the weights 1 6 15 20 15 6 1: of counts, or of their logarithms.
// entries (u32, `rows` x 256) -> smoothed (u32, `rows` x 256), plus `prior`; downwards if dy is 1, else along rows
// One invocation: four neighbours. Border: the outermost entries are repeated.
// With: common
// Reference: src/reference/cost/mi_table.rs

struct Own {
    narrowing: u32,     // bits by which entries are shifted down
    prior: u32,         // what is added to them
    logarithms: u32,    // 1: their logarithms are taken
}

@group(0) @binding(2) var<storage, read> entries: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> smoothed: array<vec4<u32>>;

// 4096 log2(v), v >= 1, by a parabola between powers of two.
fn logarithms(v: vec4<u32>) -> vec4<u32> {
    let whole = firstLeadingBit(v);
    let fraction = ((v << (vec4(31u) - whole)) >> vec4(19u)) & vec4(4095u);
    return 4096u * whole + fraction + ((fraction * (vec4(4096u) - fraction) * 11u) >> vec4(17u));
}

fn four_at(row: i32, four: i32) -> vec4<u32> {
    let line = u32(clamp(row, 0, i32(dispatch.rows) - 1));
    let values = entries[line * 64u + u32(clamp(four, 0, 63))] >> vec4(dispatch.own.narrowing);
    let continued = select(select(values, vec4(values.x), four < 0), vec4(values.w), four > 63);
    if dispatch.own.logarithms == 1u {
        return logarithms(continued);
    }
    return continued;
}

@compute @workgroup_size(LANES)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = i32(id.x / 64u);
    let four = i32(id.x % 64u);
    if row >= i32(dispatch.rows) {
        return;
    }
    let b = four_at(row, four);
    var outer: vec4<u32>;
    var middle: vec4<u32>;
    var inner: vec4<u32>;
    if dispatch.dy == 1 {
        outer = four_at(row - 3, four) + four_at(row + 3, four);
        middle = four_at(row - 2, four) + four_at(row + 2, four);
        inner = four_at(row - 1, four) + four_at(row + 1, four);
    } else {
        let a = four_at(row, four - 1);
        let c = four_at(row, four + 1);
        outer = vec4(a.yzw, b.x) + vec4(b.w, c.xyz);
        middle = vec4(a.zw, b.xy) + vec4(b.zw, c.xy);
        inner = vec4(a.w, b.xyz) + vec4(b.yzw, c.x);
    }
    smoothed[id.x] = outer + 6u * middle + 15u * inner + 20u * b + vec4(dispatch.own.prior);
}
