//! Where the values and the weights of a network lie.

use crate::Error;
use crate::gpu::layout::request::{Request, SMALLER};
use crate::gpu::layout::uniforms::TEXTURE_ROW;
use crate::network::{Convolution, Kind, Network, Operation, Padded};

/// Texels to whose multiples blocks of channels begin, so that a binding may begin with any: 256 bytes.
pub(crate) const BLOCK_UNIT: u32 = 16;

/// What the slots are planned for, so that the same operations share one at every size, and no slot grows where the images get
/// smaller.
const PLANNED: Padded = Padded { width: 1248, height: 384, disparities: 192 };

/// Where the output of an operation lies: `[block of four channels][plane][row][column]`, texels of 16 bytes. The planes of an
/// image are the two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// The memory that it shares with others, which are not needed at the same time.
    pub(crate) slot: usize,
    /// The first texel in it.
    pub(crate) at: u32,
    pub(crate) blocks: u32,
    pub(crate) planes: u32,
    pub(crate) rows: u32,
    pub(crate) columns: u32,
    /// Texels from a block to the next.
    pub(crate) stride: u32,
}

/// All places.
#[derive(Clone, Debug)]
pub(crate) struct Layers {
    pub(crate) padded: Padded,
    /// Of each operation; of the last one none is used.
    pub(crate) places: Vec<Place>,
    /// Bytes of each slot.
    pub(crate) slots: Vec<u64>,
    /// The slots that several operations fill together, and no others.
    pub(crate) joined: Vec<usize>,
    /// Bytes of the largest of their parts.
    pub(crate) part: u64,
    /// Bytes of the largest output.
    pub(crate) largest: u64,
    /// Bytes of the disparities.
    pub(crate) disparities: u64,
}

impl Place {
    fn new(operation: &Operation, padded: &Padded) -> Self {
        let [channels, planes, rows, columns] = operation.shape(padded).map(|side| side as u32);
        let planes = if operation.both_sides { 2 } else { planes };
        let stride = (planes * rows * columns).next_multiple_of(BLOCK_UNIT);
        Self { slot: 0, at: 0, blocks: channels.div_ceil(4), planes, rows, columns, stride }
    }

    /// Bytes of its blocks.
    pub(crate) fn values(&self) -> u64 {
        16 * u64::from(self.blocks) * u64::from(self.stride)
    }

    /// The same in whole rows of a texture.
    pub(crate) fn bytes(&self) -> u64 {
        self.values().next_multiple_of(TEXTURE_ROW)
    }
}

impl Layers {
    /// For images of the size of the request; an error if a part is larger than the device allows.
    pub(super) fn new(request: &Request<'_>, network: &Network) -> Result<Self, Error> {
        let Request { width, height, params, limits, plan, .. } = *request;
        let padded = Padded::new(width, height, params.disparities);
        let operations = network.operations();
        let owners = owners(operations);
        let (slot_of, count) = slots(operations, &owners);
        let mut places: Vec<Place> = operations.iter().map(|operation| Place::new(operation, &padded)).collect();
        let mut slots = vec![0; count];
        for at in 0..places.len() - 1 {
            let (owner, block) = owners[at];
            places[at].slot = slot_of[owner];
            places[at].at = block * places[at].stride;
            slots[slot_of[owner]] = places[owner].bytes().max(slots[slot_of[owner]]);
        }
        let joins = |at: &usize| operations[*at].kind == Kind::Concat;
        let joined = (0..operations.len()).filter(joins).map(|at| slot_of[at]).collect();
        let parts = (0..operations.len()).filter(|&at| owners[at].0 != at).map(|at| places[at].bytes());
        let part = parts.max().unwrap_or(0);
        let largest = slots.iter().copied().max().unwrap_or(0);
        let block = places.iter().map(|place| 16 * u64::from(place.stride)).max().unwrap_or(0);
        request.fits("four channels of a volume of the network", block, FEWER_OF_NETWORK)?;
        let texture = u64::from(limits.max_texture_dimension_2d) * TEXTURE_ROW;
        let allowed = if plan.per_subgroup { limits.max_buffer_size } else { texture.min(limits.max_buffer_size) };
        if largest > allowed {
            let what = "a volume of the network".into();
            return Err(Error::TooLarge { what, needed: largest, allowed, remedy: FEWER_OF_NETWORK });
        }
        let weights = weight_places(network).0.into_iter().map(|[first, end]| 16 * u64::from(end - first + BLOCK_UNIT));
        request.fits("the weights of an operation of the network", weights.max().unwrap_or(0), LARGER_BINDING)?;
        let disparities = 4 * padded.width as u64 * padded.height as u64;
        request.fits("the disparities of the network", disparities, SMALLER)?;
        Ok(Self { padded, places, slots, joined, part, largest, disparities })
    }
}

/// The remedy where weights are too many.
const LARGER_BINDING: &str = "request a device with a larger max_storage_buffer_binding_size";

/// The remedy where a volume is too large.
const FEWER_OF_NETWORK: &str = "use fewer disparities or smaller images";

/// The operation in whose memory the output of each one lies, and the first block of channels there: what is joined lies side by
/// side from the beginning.
fn owners(operations: &[Operation]) -> Vec<(usize, u32)> {
    let mut owners: Vec<(usize, u32)> = (0..operations.len()).map(|at| (at, 0)).collect();
    for (at, operation) in operations.iter().enumerate().filter(|(_, operation)| operation.kind == Kind::Concat) {
        let mut block = 0;
        for &input in &operation.inputs {
            owners[input] = (at, block);
            block += operations[input].channels.div_ceil(4) as u32;
        }
    }
    owners
}

/// The slot of each operation that is an owner, and how many there are: the smallest one that is free and large enough at the size
/// of [`PLANNED`], the largest one that is free, or a new one. What is joined has one of its own.
fn slots(operations: &[Operation], owners: &[(usize, u32)]) -> (Vec<usize>, usize) {
    let reads = Operation::last_reads(operations);
    let mut last = vec![0; operations.len()];
    for (at, &(owner, _)) in owners.iter().enumerate() {
        last[owner] = reads[at].max(last[owner]);
    }
    let mut slot_of = vec![usize::MAX; operations.len()];
    // Of each slot: its bytes, and the last operation that reads it.
    let mut slots: Vec<(u64, usize)> = Vec::new();
    for (at, &(owner, _)) in owners.iter().enumerate().take(operations.len() - 1) {
        if slot_of[owner] != usize::MAX {
            continue;
        }
        let bytes = Place::new(&operations[owner], &PLANNED).bytes();
        if operations[owner].kind == Kind::Concat {
            slot_of[owner] = slots.len();
            slots.push((bytes, usize::MAX));
            continue;
        }
        let free = || (0..slots.len()).filter(|&slot| slots[slot].1 < at);
        let fitting = free().filter(|&slot| slots[slot].0 >= bytes).min_by_key(|&slot| slots[slot].0);
        let slot = fitting.or_else(|| free().max_by_key(|&slot| slots[slot].0)).unwrap_or_else(|| {
            slots.push((0, 0));
            slots.len() - 1
        });
        slots[slot] = (bytes.max(slots[slot].0), last[owner]);
        slot_of[owner] = slot;
    }
    (slot_of, slots.len())
}

/// The first texel of each operation's weights in [`packed`] and the one behind its last, and the bytes of all.
pub(crate) fn weight_places(network: &Network) -> (Vec<[u32; 2]>, u64) {
    let mut texels = 0;
    let places = network.operations().iter().map(|operation| {
        let first = texels;
        if let Some(convolution) = network.convolution(&operation.name) {
            let [outputs, inputs, taps] = sides(convolution).map(|side| side as u32);
            texels += outputs.div_ceil(4) * (1 + 4 * inputs.div_ceil(4) * taps);
        }
        [first, texels]
    });
    let places = places.collect();
    (places, (16 * u64::from(texels)).next_multiple_of(TEXTURE_ROW))
}

/// Outputs, inputs and taps of a convolution.
fn sides(convolution: &Convolution) -> [usize; 3] {
    let shape = convolution.weights.shape();
    [shape[0], shape[1], shape[2..].iter().product()]
}

/// The weights of a network as the kernels read them, four of them a texel.
pub(crate) fn packed(network: &Network) -> Vec<f32> {
    let mut texels = Vec::new();
    for operation in network.operations() {
        if let Some(convolution) = network.convolution(&operation.name) {
            pack(convolution, &mut texels);
        }
    }
    texels.resize(texels.len().next_multiple_of(TEXTURE_ROW as usize / 4), 0.0);
    texels
}

/// Of one operation: the bias of each block of four outputs, then of each `[block of inputs][tap][input]`, four outputs a texel.
fn pack(convolution: &Convolution, texels: &mut Vec<f32>) {
    let [outputs, inputs, taps] = sides(convolution);
    let weights = convolution.weights.data();
    let blocks = outputs.div_ceil(4);
    texels.extend((0..4 * blocks).map(|output| convolution.bias.get(output).copied().unwrap_or(0.0)));
    for block in 0..blocks {
        for from in 0..inputs.div_ceil(4) {
            for tap in 0..taps {
                for input in 4 * from..4 * from + 4 {
                    let weight = |output: usize| match input < inputs && output < outputs {
                        true => weights[(output * inputs + input) * taps + tap],
                        false => 0.0,
                    };
                    texels.extend((4 * block..4 * block + 4).map(weight));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::network::{Architecture, Extent, tiny};

    /// The places are those at which the weights of each operation are packed.
    #[test]
    fn weights_lie_at_their_places() {
        let network = tiny::tiny(3);
        let ((places, bytes), texels) = (weight_places(&network), packed(&network));
        assert_eq!(bytes, 4 * texels.len() as u64);
        for (operation, [first, end]) in network.operations().iter().zip(places) {
            let Some(convolution) = network.convolution(&operation.name) else { continue };
            let mut own = Vec::new();
            pack(convolution, &mut own);
            assert_eq!(texels[4 * first as usize..4 * end as usize], own, "{}", operation.name);
        }
    }

    /// What is written never lies where values lie that are still read.
    #[test]
    fn slots_are_free_when_they_are_written() {
        for architecture in Architecture::ALL {
            let operations = architecture.operations();
            let owners = owners(&operations);
            let (slot_of, count) = slots(&operations, &owners);
            assert!(count < 9, "{architecture}: {count}");
            let reads = Operation::last_reads(&operations);
            for (at, &(owner, _)) in owners.iter().enumerate().take(operations.len() - 1) {
                for earlier in 0..at {
                    let (other, _) = owners[earlier];
                    let free = reads[earlier] < at || slot_of[other] != slot_of[owner];
                    assert!(free || other == owner, "{architecture}: {earlier} is lost by {at}");
                }
                assert!(matches!(operations[at].extent, Extent::Volume(_)) || operations[at].both_sides);
            }
        }
    }
}
