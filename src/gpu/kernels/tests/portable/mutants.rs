//! The tests of the tests.

use super::barriers::lonely_barriers;
use super::functions::understood;
use super::integers::doubtful_integers;
use super::types::other_types;

#[test]
fn barriers_that_some_do_not_reach_are_found() {
    let kernel = |body: &str| {
        format!(
            "struct Block {{ rows: u32, list: array<vec4<u32>, 4> }}
            @group(0) @binding(0) var<uniform> block: Block;
            @group(0) @binding(1) var<storage, read_write> data: array<u32>;
            var<workgroup> places: array<u32, 64>;
            var<private> member: u32;
            fn wait(v: u32) {{ places[member] = v; workgroupBarrier(); }}
            fn two(v: u32) {{ wait(v); wait(v + 1u); }}
            fn own(v: u32) -> bool {{ return v > 3u; }}
            fn leave(v: ptr<function, u32>) {{ *v = member; }}
            fn maybe(v: u32) {{ if v > 2u {{ return; }} workgroupBarrier(); }}
            @compute @workgroup_size(64)
            fn main(@builtin(local_invocation_index) local: u32, @builtin(global_invocation_id) id: vec3<u32>) {{
                member = local;
                let rows = block.rows;
                {body}
            }}"
        )
    };
    for (body, expected) in [
        ("workgroupBarrier();", false),
        ("for (var i = 0u; i < rows; i++) { wait(i + local); }", false),
        ("if rows > 3u { two(local); }", false),
        ("if local > 3u { data[0] = 1u; } two(1u);", false),
        ("var n = rows; if own(n) { return; } wait(local);", false),
        ("for (var i = 0u; i < rows; i++) { if i == 7u { break; } wait(i); }", false),
        ("switch block.list[1].x { case 1u: { wait(1u); } default: { } }", false),
        ("var i = 0u; loop { if local == i { data[1] = i; } wait(i); continuing { i++; break if i == rows; } }", false),
        ("maybe(rows);", false),
        ("if local > 3u { return; } workgroupBarrier();", true),
        ("if local > 3u && false { return; } two(1u);", true),
        ("if id.x > 3u { wait(1u); }", true),
        ("if rows > 3u { if own(local) { two(1u); } }", true),
        ("for (var i = 0u; i < local; i++) { wait(i); }", true),
        ("for (var i = 0u; i < rows; i++) { if i == local { break; } wait(i); }", true),
        ("for (var i = 0u; i < rows; i++) { wait(i); if i == local { continue; } }", true),
        ("for (var i = 0u; i < rows; i++) { wait(i); if i == local { return; } }", true),
        ("var n = rows; if local == 2u { n = 1u; } for (var i = 0u; i < n; i++) { wait(i); }", true),
        ("var n = rows; leave(&n); if n == 2u { wait(1u); }", true),
        ("if data[2] == 0u { wait(1u); }", true),
        ("if places[2] == 0u { wait(1u); }", true),
        ("switch local { case 1u: { wait(1u); } default: { } }", true),
        ("var i = 0u; loop { wait(i); continuing { i++; break if i == local; } }", true),
        ("while true { wait(1u); if own(member) { break; } }", true),
        ("maybe(local);", true),
    ] {
        let found = !lonely_barriers(&understood(&kernel(body)).unwrap().0).is_empty();
        assert_eq!(found, expected, "{body}");
    }
}

#[test]
fn doubtful_integers_are_found() {
    let kernel = |expression: &str| {
        format!(
            "struct Own {{ halvings: u32, other: u32 }}
            struct Dispatch {{ rows: u32, @align(16) own: Own }}
            @group(0) @binding(0) var<uniform> dispatch: Dispatch;
            @group(0) @binding(1) var<storage, read_write> data: array<u32>;
            fn shifted(v: u32, by: u32) -> u32 {{ return v >> by; }}
            @compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
                let u = id.x; let i = i32(id.y); let v = vec4(id.x, id.y, id.z, 1u);
                data[0] = u32({expression});
                for (var n = 0u; n < 8u; n++) {{ data[1] = 1u << (4u * n + 3u); }}
            }}"
        )
    };
    for (expression, expected) in [
        ("u % 3u + u / 5u", 0),
        ("u >> 31u", 0),
        ("i >> 4u", 0),
        ("u << (8u * (u & 3u))", 0),
        ("u << (31u - 8u * (u % 4u))", 0),
        ("(v << vec4(0u, 8u, 16u, 24u)).x", 0),
        ("1u << dispatch.own.halvings", 0),
        ("1u << min(u, 31u)", 0),
        ("shifted(u, 3u) + shifted(u, u & 31u)", 0),
        ("u >> select(4u, 8u, u > 3u)", 0),
        ("i % 3", 1),
        ("i / 3", 1),
        ("(vec4(i) % vec4(3)).x", 1),
        ("i << 2u", 1),
        ("u << u", 1),
        ("u << (32u - 8u * (u & 3u))", 1),
        ("u >> (8u * (u & 7u))", 1),
        ("1u << dispatch.own.other", 1),
        ("shifted(u, 3u) + shifted(u, u)", 1),
        ("(v >> vec4(u)).x", 1),
        ("u >> (u - 1u)", 1),
    ] {
        let (module, info) = understood(&kernel(expression)).unwrap();
        let wrong = doubtful_integers(&module, &info);
        assert_eq!(wrong.len(), expected, "{expression}: {wrong:?}");
    }
}

#[test]
fn other_types_are_found() {
    let kernel = |body: &str| {
        format!(
            "alias Sums = array<vec4<u32>, 2>;
            struct Pair {{ a: Sums, b: u32 }}
            @group(0) @binding(0) var<storage, read_write> data: array<vec4<u32>>;
            fn take(s: Sums) -> vec4<u32> {{ return s[0]; }}
            fn change(s: ptr<function, Sums>) {{ (*s)[0] = vec4(1u); }}
            {body}
            @compute @workgroup_size(1) fn main() {{ data[0] = take(f()); }}"
        )
    };
    for (body, expected) in [
        ("fn f() -> Sums { return Sums(vec4(1u), vec4(2u)); }", 0),
        ("fn f() -> Sums { var s = Sums(); s[0] = vec4(1u); change(&s); return s; }", 0),
        ("fn f() -> Sums { let p = Pair(Sums(), 1u); return p.a; }", 0),
        ("fn f() -> Sums { return array(vec4(1u), vec4(2u)); }", 1),
        ("fn f() -> Sums { return array<vec4<u32>, 2>(vec4(1u), vec4(2u)); }", 1),
        ("fn g(a: array<vec4<u32>, 2>) -> Sums { return a; } fn f() -> Sums { return g(array<vec4<u32>, 2>()); }", 1),
        ("fn f() -> Sums { var s: Sums; s = array(vec4(1u), vec4(2u)); return s; }", 1),
        ("fn f() -> Sums { let a = array(vec4(1u), vec4(2u)); data[1] = take(a); return Sums(); }", 1),
        ("fn f() -> Sums { var a = array(vec4(1u), vec4(2u)); change(&a); return Sums(); }", 1),
        ("fn f() -> Sums { let p = Pair(array(vec4(1u), vec4(2u)), 1u); return p.a; }", 1),
    ] {
        let wrong = match understood(&kernel(body)) {
            Ok((module, info)) => other_types(&module, &info),
            Err(refused) => vec![refused],
        };
        assert_eq!(wrong.len(), expected, "{body}: {wrong:#?}");
    }
}
