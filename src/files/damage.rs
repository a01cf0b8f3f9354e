//! Files as they should not be, for tests.

use rand::Rng;
use rand_chacha::ChaCha8Rng;

/// Bytes changed in a few places; some of what is put in is of `telling`, bytes that mean something in such files.
pub(super) fn damaged(seed: &[u8], random: &mut ChaCha8Rng, telling: &[u8]) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..random.random_range(1..6) {
        let at = random.random_range(0..=bytes.len());
        match random.random_range(0..6) {
            0 => bytes.truncate(at),
            1 => bytes.insert(at, random.random()),
            2 => bytes.splice(at..at, *b"99999").for_each(drop),
            3 => bytes.extend_from_within(at..),
            4 => bytes.splice(at..at, [telling[random.random_range(0..telling.len())]]).for_each(drop),
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = [byte.wrapping_add(1), *byte ^ (1 << random.random_range(0..8)), random.random()]
                        [random.random_range(0..3)];
                }
            }
        }
    }
    bytes
}
