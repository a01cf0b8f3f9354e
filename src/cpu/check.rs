//! The comparison of each stage with the reference.

use crate::check::StageCheck;
use crate::cpu::chain::Native;
use crate::cpu::instructions::Instructions;
use crate::cpu::paths::Buffers;
use crate::reference::{Bytes, Part, Plane, Report, Stages, follow};
use crate::{Error, ImageView, Params};
use std::collections::VecDeque;

/// What the native schedule made: a stage's name and bytes, in the order of the chain.
type Made = VecDeque<(String, Vec<u8>)>;

/// The row of the maps that a run gives that keeps no stages.
const MAPS: &str = "maps";

/// The definition, but for a network: that is computed in floats, and what follows it starts from its disparities.
struct AfterNetwork(VecDeque<Plane<f32>>);

impl Stages for AfterNetwork {
    fn infer(&mut self, _: [ImageView<'_>; 2], _: &Params, _: Report<'_>) -> Result<Plane<f32>, Error> {
        self.0.pop_front().ok_or_else(|| Error::Misuse("a network was not run".into()))
    }
}

/// Computes a pair twice, with and without keeping the results of stages, and compares all that was made with the reference.
/// `spoil` may change what stages made before.
pub(super) fn check(
    pair: [ImageView<'_>; 2],
    params: &Params,
    (instructions, buffers): (Instructions, &Buffers),
    spoil: &mut dyn FnMut(&str, &mut [u8]),
) -> Result<Vec<StageCheck>, Error> {
    let mut made = Made::new();
    let mut native = Native::new(instructions, buffers);
    let receive = &mut |stage: &str, result: &dyn Bytes| {
        let mut bytes = Vec::new();
        result.append_to(&mut bytes);
        spoil(stage, &mut bytes);
        made.push_back((stage.into(), bytes));
    };
    follow(pair, params, Some(receive), &mut native)?;
    let (matched, _) = follow(pair, params, None, &mut Native::new(instructions, buffers))?;
    receive(MAPS, &matched);

    let mut stages = Vec::new();
    let mut compare = |stage: &str, result: &dyn Bytes| {
        let at = made.iter().position(|(name, _)| name == stage);
        let Some((_, got)) = at.and_then(|at| made.remove(at)) else { return };
        let (mut expected, mut parts) = (Vec::new(), Vec::new());
        result.append_to(&mut expected);
        result.append_parts(&mut parts);
        compare_numbers(row_of(&mut stages, stage), &parts, &expected, &got);
    };
    let mut reference = AfterNetwork(native.inferred.into());
    let (matched, _) = follow(pair, params, Some(&mut compare), &mut reference)?;
    compare(MAPS, &matched);
    // Of the operations of a network there are names alone. Nothing else is left, unless a stage has another name or comes once
    // more: then nothing that it made is right.
    for (stage, bytes) in made.iter().filter(|(_, bytes)| !bytes.is_empty()) {
        row_of(&mut stages, stage).mismatches += bytes.len() as u64;
    }
    Ok(stages)
}

/// The row of a stage.
fn row_of<'a>(stages: &'a mut Vec<StageCheck>, stage: &str) -> &'a mut StageCheck {
    let known = stages.iter().position(|row| row.stage == stage);
    let at = known.unwrap_or_else(|| {
        stages.push(StageCheck { stage: stage.into(), elements: 0, mismatches: 0, first: None });
        stages.len() - 1
    });
    &mut stages[at]
}

/// Compares numbers part by part.
fn compare_numbers(row: &mut StageCheck, parts: &[Part], mut expected: &[u8], mut got: &[u8]) {
    for part in parts {
        let bytes = part.count * part.bytes;
        let (here, rest) = expected.split_at(bytes.min(expected.len()));
        let (found, rest_found) = got.split_at(bytes.min(got.len()));
        (expected, got) = (rest, rest_found);
        if here == found {
            row.elements += part.count as u64;
            continue;
        }
        let pixels = part.width.max(1);
        for (i, number) in here.chunks_exact(part.bytes).enumerate() {
            let pixel = i / part.depth;
            let (x, y) = if part.width == 0 { (pixel, 0) } else { (pixel % pixels, pixel / pixels) };
            let d = (part.depth > 1).then_some(i % part.depth);
            let found = found.get(i * part.bytes..(i + 1) * part.bytes);
            // What is missing is wrong.
            let expected = number_of(number, part.signed);
            row.compare(x, y, d, expected, found.map_or(!expected, |found| number_of(found, part.signed)));
        }
    }
    row.mismatches += got.len() as u64;
}

/// The number of these bytes, the lowest first.
fn number_of(bytes: &[u8], signed: bool) -> i64 {
    let negative = signed && bytes.last().is_some_and(|last| last & 0x80 != 0);
    bytes.iter().rev().fold(if negative { -1 } else { 0 }, |number, &byte| number << 8 | i64::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::DisparityMap;

    #[test]
    fn what_differs_is_found_where_it_is() {
        let map = |data| DisparityMap { width: 2, height: 2, data };
        let compared = |expected: &DisparityMap, got: &[u8]| {
            let (mut bytes, mut parts) = (Vec::new(), Vec::new());
            expected.append_to(&mut bytes);
            expected.append_parts(&mut parts);
            let mut row = StageCheck { stage: "median".into(), elements: 0, mismatches: 0, first: None };
            compare_numbers(&mut row, &parts, &bytes, got);
            row
        };
        let expected = map(vec![1, -2, 300, i16::MIN]);
        let mut bytes = Vec::new();
        expected.append_to(&mut bytes);
        let right = compared(&expected, &bytes);
        assert_eq!((right.elements, right.mismatches, right.first), (4, 0, None));
        bytes[2] ^= 1;
        let first = compared(&expected, &bytes).first.unwrap();
        assert_eq!((first.x, first.y, first.d, first.expected, first.got), (1, 0, None, -2, -1));
        bytes[2] ^= 1;
        assert_eq!(compared(&expected, &bytes[..6]).mismatches, 1); // too little
        bytes.push(0);
        assert_eq!(compared(&expected, &bytes).mismatches, 1); // too much
    }
}
