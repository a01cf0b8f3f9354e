// Appended to the kernels of the median of 5x5 values: networks that put values in order.

// Five values a lane, ascending.
struct Five {
    a: vec4<i32>,
    b: vec4<i32>,
    c: vec4<i32>,
    d: vec4<i32>,
    e: vec4<i32>,
}

fn ascending(v: Five) -> Five {
    let a = min(v.a, v.b);
    let b = max(v.a, v.b);
    let d = min(v.d, v.e);
    let e = max(v.d, v.e);
    let c = min(v.c, e);
    let high = max(v.c, e);
    let low = min(c, d);
    let mid = max(c, d);
    let x = min(b, high);
    let y = min(a, mid);
    let z = max(a, mid);
    let u = max(y, low);
    let w = min(x, z);
    return Five(min(y, low), min(w, u), max(w, u), max(x, z), max(b, high));
}

// The largest and the second largest of four.
fn largest(a: vec4<i32>, b: vec4<i32>, c: vec4<i32>, d: vec4<i32>) -> array<vec4<i32>, 2> {
    let e = max(a, b);
    let f = max(c, d);
    return array(max(e, f), max(min(e, f), max(min(a, b), min(c, d))));
}

// The smallest and the second smallest of four.
fn smallest(a: vec4<i32>, b: vec4<i32>, c: vec4<i32>, d: vec4<i32>) -> array<vec4<i32>, 2> {
    let e = min(a, b);
    let f = min(c, d);
    return array(min(e, f), min(max(e, f), min(max(a, b), max(c, d))));
}

// Of five columns in order, the values of each rank put in order, too: twelve of the 25 are then below the thirteenth or
// above it by their places. Of the others, on three diagonals, each value is at most its neighbours on the next.
fn median(a: Five, b: Five, c: Five, d: Five, e: Five) -> vec4<i32> {
    let first = ascending(Five(a.a, b.a, c.a, d.a, e.a));
    let second = ascending(Five(a.b, b.b, c.b, d.b, e.b));
    let third = ascending(Five(a.c, b.c, c.c, d.c, e.c));
    let fourth = ascending(Five(a.d, b.d, c.d, d.d, e.d));
    let fifth = ascending(Five(a.e, b.e, c.e, d.e, e.e));
    let low = largest(first.d, second.c, third.b, fourth.a);
    let middle = ascending(Five(first.e, second.d, third.c, fourth.b, fifth.a));
    let high = smallest(second.e, third.d, fourth.c, fifth.b);
    let third_of_middle = min(middle.c, max(low[1], max(min(low[0], high[1]), high[0])));
    return max(max(middle.b, third_of_middle), min(middle.d, min(low[0], high[0])));
}
