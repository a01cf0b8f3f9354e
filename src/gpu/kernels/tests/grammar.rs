//! What the text of a kernel must not contain though naga takes it, because other compilers of WGSL refuse it or read it in
//! another way: operators that WGSL's grammar does not let stand side by side, and variables of a loop without an initial
//! value, which SPIR-V does not set to zero again in each round.

use super::specialisations::every_text;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Token<'a> {
    /// An identifier, a keyword or a number.
    Word(&'a str),
    /// Anything else.
    Sign(&'a str),
}
use Token::{Sign, Word};

/// The longest first.
const SIGNS: [&str; 24] = [
    "<<=", ">>=", "->", "<<", ">>", "<=", ">=", "==", "!=", "&&", "||", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=",
    "|=", "^=", "::", "//", "/*",
];

/// Words after which `<` opens a list of types.
fn takes_types(word: &str) -> bool {
    let prefixes = ["vec2", "vec3", "vec4", "mat", "array", "ptr", "atomic", "var", "texture_", "bitcast"];
    prefixes.iter().any(|prefix| if *prefix == "var" { word == "var" } else { word.starts_with(prefix) })
}

/// The tokens of a text, without comments and without lists of types.
fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let length = if is_word(first) {
            // A point between digits belongs to a number.
            let number = first.is_ascii_digit();
            rest.find(|c: char| !(is_word(c) || number && c == '.')).unwrap_or(rest.len())
        } else {
            SIGNS.iter().find(|sign| rest.starts_with(**sign)).map_or(first.len_utf8(), |sign| sign.len())
        };
        let (token, after) = rest.split_at(length);
        rest = after;
        if token == "//" {
            rest = rest.find('\n').map_or("", |end| &rest[end..]);
        } else if is_word(first) {
            tokens.push(Word(token));
            if takes_types(token) && rest.starts_with('<') {
                let mut depth = 0;
                let end = rest.char_indices().find(|&(_, c)| {
                    depth += i32::from(c == '<') - i32::from(c == '>');
                    depth == 0
                });
                rest = end.map_or("", |(at, _)| &rest[at + 1..]);
            }
        } else {
            assert_ne!(token, "/*", "comments are lines");
            tokens.push(Sign(token));
        }
        rest = rest.trim_start();
    }
    tokens
}

/// How binary operators may stand side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    Arithmetic,
    Shift,
    Relation,
    /// One of `&`, `|` and `^`, only with itself.
    Bits,
    /// One of `&&` and `||`, only with itself among these.
    Logic,
}

fn class(sign: &str) -> Option<Class> {
    Some(match sign {
        "+" | "-" | "*" | "/" | "%" => Class::Arithmetic,
        "<<" | ">>" => Class::Shift,
        "<" | ">" | "<=" | ">=" | "==" | "!=" => Class::Relation,
        "&" | "|" | "^" => Class::Bits,
        "&&" | "||" => Class::Logic,
        _ => return None,
    })
}

/// What is wrong with the binary operators of an expression, those within its parentheses left out.
fn mixed(operators: &[&str]) -> Option<String> {
    let all = |wanted| operators.iter().copied().filter(move |sign| class(sign) == Some(wanted));
    let wrong = || Some(operators.join(" "));
    let differ = |mut signs: Box<dyn Iterator<Item = &str> + '_>| {
        let first = signs.next();
        signs.any(|sign| Some(sign) != first)
    };
    if all(Class::Bits).next().is_some() && differ(Box::new(operators.iter().copied())) {
        return wrong();
    }
    if differ(Box::new(all(Class::Logic))) {
        return wrong();
    }
    for relation in operators.split(|sign| class(sign) == Some(Class::Logic)) {
        let count = |wanted| relation.iter().filter(|sign| class(sign) == Some(wanted)).count();
        if count(Class::Relation) > 1 {
            return wrong();
        }
        for side in relation.split(|sign| class(sign) == Some(Class::Relation)) {
            if side.len() > 1 && side.iter().any(|sign| class(sign) == Some(Class::Shift)) {
                return wrong();
            }
        }
    }
    None
}

/// Words behind which a sign has nothing on its left.
const STATEMENTS: [&str; 4] = ["return", "if", "while", "switch"];

/// The expressions of a text that WGSL's grammar does not know, by their operators.
fn unparenthesised(text: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut open: Vec<Vec<&str>> = vec![Vec::new()];
    let mut before = None;
    for token in tokens(text) {
        let operand = matches!(before, Some(Word(word)) if !STATEMENTS.contains(&word))
            || matches!(before, Some(Sign(")" | "]" | "++" | "--")));
        match token {
            Sign("(" | "[") => open.push(Vec::new()),
            Sign(sign) if operand && class(sign).is_some() => open.last_mut().unwrap().push(sign),
            // Those in front of an operand.
            Sign("-" | "!" | "~" | "*" | "&" | ".") => (),
            Sign(sign) => {
                wrong.extend(mixed(open.last().unwrap()));
                open.last_mut().unwrap().clear();
                if matches!(sign, ")" | "]") {
                    open.pop();
                    assert!(!open.is_empty(), "a parenthesis is closed that was not opened");
                }
            }
            Word(word) => {
                if STATEMENTS.contains(&word) {
                    open.last_mut().unwrap().clear();
                }
            }
        }
        before = Some(token);
    }
    wrong
}

/// The variables that are declared in a loop without an initial value.
fn unset_in_loops(text: &str) -> Vec<String> {
    let tokens = tokens(text);
    let mut wrong = Vec::new();
    // Of each open block whether it is a loop's.
    let mut blocks = Vec::new();
    let mut next_is_loop = false;
    for (i, token) in tokens.iter().enumerate() {
        match token {
            Word("for" | "while" | "loop" | "continuing") => next_is_loop = true,
            Sign("{") => blocks.push(std::mem::take(&mut next_is_loop)),
            Sign("}") => drop(blocks.pop()),
            Word("var") if blocks.contains(&true) => {
                let declaration = tokens[i..].iter().take_while(|token| **token != Sign(";"));
                if !declaration.clone().any(|token| *token == Sign("=")) {
                    let words = declaration.filter_map(|token| match token {
                        Word(word) => Some(*word),
                        Sign(_) => None,
                    });
                    wrong.push(words.collect::<Vec<_>>().join(" "));
                }
            }
            _ => (),
        }
    }
    wrong
}

#[test]
fn operators_are_parenthesised_as_the_grammar_has_it() {
    for (name, text) in every_text() {
        let wrong = unparenthesised(text);
        assert!(wrong.is_empty(), "{name}.wgsl: WGSL wants parentheses between {wrong:?}");
    }
}

#[test]
fn variables_of_loops_have_initial_values() {
    for (name, text) in every_text() {
        let wrong = unset_in_loops(text);
        assert!(wrong.is_empty(), "{name}.wgsl: in a loop, without an initial value: {wrong:?}");
    }
}

/// The test of the first test.
/// Statements that hold an expression.
fn statements(expression: &str) -> impl Iterator<Item = String> {
    let around = ["return {};", "let x = {};", "if {} { }", "x += {};", "x = f(1u, {}, y);", "for (; {}; i++) { }"];
    around.into_iter().map(move |around| around.replace("{}", expression))
}

#[test]
fn missing_parentheses_are_found() {
    for expression in [
        "a * b | c",
        "a | b & c",
        "a << 1u | b",
        "a + b << 2u",
        "a << b + c",
        "a & b == c",
        "a == b & c",
        "a < b == c",
        "a && b || c",
        "f(a * a | (b << 1u))",
        "x[a ^ b + 1u]",
        "a << 1u << 2u",
        "a % b & c",
        "-a & b | c",
        "a & b + c",
        "(a & b) | c + d",
        "a - b >> c",
    ] {
        for text in statements(expression) {
            assert!(!unparenthesised(&text).is_empty(), "{text} passed");
        }
    }
    for expression in [
        "(a * b) | c",
        "a | b | c",
        "(a << 1u) | b",
        "a + b * c % d",
        "a < b && c + d >= e && f",
        "a << (b + c)",
        "-a & ~b",
        "(a & b) == c",
        "x < (y >> 3u) || z",
        "vec4<u32>(a) >> vec4(b)",
        "a + f(b & c)",
        "a == b",
        "1.5 * a",
        "a >> 1u <= b << 2u",
        "array<vec4<u32>, 2>(a, b)",
        "a - -b",
    ] {
        for text in statements(expression) {
            assert_eq!(unparenthesised(&text), Vec::<String>::new(), "{text}");
        }
    }
}

/// The test of the second one.
#[test]
fn unset_variables_are_found() {
    let kernel =
        |body: &str| format!("fn f() -> u32 {{ var a: u32; {body} return a; }} fn g() {{ var b: vec4<u32>; }}");
    for (body, expected) in [
        ("", 0),
        ("for (var i = 0u; i < 4u; i++) { var x = Words(); }", 0),
        ("for (var i = 0u; i < 4u; i++) { f(); } var x: u32;", 0),
        ("for (var i = 0u; i < 4u; i++) { var x: array<u32, 4>; }", 1),
        ("while a < 4u { if a == 2u { var x: u32; } }", 1),
        ("loop { { var x: u32; var y: u32; } continuing { var z: u32; } }", 3),
        ("for (var i: u32; i < 4u; i++) { }", 0),
        ("loop { for (var i: u32; i < 4u; i++) { } }", 1),
        ("loop { // var x: u32;\n var x = 1u; }", 0),
    ] {
        assert_eq!(unset_in_loops(&kernel(body)).len(), expected, "{body}");
    }
}
