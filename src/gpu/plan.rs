//! How the work of a path or a row is spread over invocations.

use crate::{Params, Paths, Schedule};

/// How invocations that share the disparities of a pixel exchange values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Exchange {
    Alone,
    Subgroup,
    Workgroup,
}

/// The schedule of a matcher: [`Schedule`] applied to a device and a number of disparities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Plan {
    /// Whether this is [`Schedule::PerSubgroup`].
    pub(crate) per_subgroup: bool,
    /// Invocations that share the disparities of a pixel: a power of two.
    pub(crate) members: u32,
    pub(crate) exchange: Exchange,
    /// Vectors of 16 disparities that each of them owns.
    pub(crate) own_quads: u32,
    /// Neighbours that can exchange values through a subgroup, whether or not they share a path; 1 if none can.
    pub(crate) subgroup: u32,
    /// Threads of a CPU device: few lines at once for each, so that what one step leaves is in a cache for the next.
    pub(crate) threads: Option<u32>,
    /// Vectors of 16 disparities that a load or store of a volume moves: 1, or 2 as 64-bit integers.
    pub(crate) width: u32,
    /// Whether penalties are loaded for each step of a path.
    pub(crate) adaptive: bool,
    /// As in `Sizes`.
    pub(crate) part_bits: Option<u32>,
}

/// Vectors of 16 disparities that an invocation of [`Schedule::PerThread`] owns, if others may take the rest. More of them
/// make code that neither the registers nor the instruction cache of a CPU hold (docs/PERFORMANCE.md).
const MOST_QUADS: u32 = 6;

/// Invocations a workgroup of the kernels that walk paths, with the schedule `per-thread`.
pub(crate) const STRIP_LANES: u32 = 8;

/// Bytes of a volume that a strip of rows takes, if that keeps all threads busy: a few volumes of it fit a last-level
/// cache.
pub(crate) const ROWS_BYTES: u64 = 5 << 20;

/// The same of a strip of paths that cross rows, which are walked there and back.
pub(crate) const PATHS_BYTES: u64 = 2 << 20;

/// Strips of an image: each has a price.
const MOST_STRIPS: u32 = 32;

/// Trips of a loop that Mesa unrolls. A loop over more vectors stays a loop, and lavapipe leaves all loops of an
/// invocation after 65,535 rounds, without a word: a long row would not be finished. Rather than that, invocations of
/// [`Schedule::PerThread`] share a path through workgroup memory, which is slow there.
pub(crate) const MOST_TRIPS: u32 = 32;

/// The same for [`Schedule::PerSubgroup`]: with more of them compilers for GPUs run out of registers (docs/COMPILERS.md).
const MOST_GROUP_QUADS: u32 = 2;

/// Invocations that may share a path through workgroup memory.
const MOST_MEMBERS: u32 = 32;

/// Invocations a workgroup of the kernels that share disparities, on a GPU: a multiple of every subgroup's size, so
/// that neighbours of a power of two lie in one subgroup.
pub(crate) const GROUP_LANES: u32 = 64;

/// Parts of one binding each that the trees of the speckle filter may be cut into.
pub(crate) const MOST_PARTS: u32 = 4;

impl Plan {
    /// Bindings that hold the trees of the speckle filter.
    pub(crate) fn parts(&self) -> u32 {
        if self.part_bits.is_some() { MOST_PARTS } else { 1 }
    }

    pub(crate) fn new(device: &wgpu::Device, params: &Params) -> Self {
        let info = device.adapter_info();
        let per_subgroup = match params.schedule {
            Schedule::Auto => info.device_type != wgpu::DeviceType::Cpu,
            Schedule::PerThread => false,
            Schedule::PerSubgroup => true,
        };
        let features = device.features();
        let subgroup = if features.contains(wgpu::Features::SUBGROUP) { info.subgroup_min_size } else { 1 };
        let threads = std::thread::available_parallelism().map_or(1, |threads| threads.get() as u32);
        let on_cpu = !per_subgroup && info.device_type == wgpu::DeviceType::Cpu;
        Self {
            threads: on_cpu.then_some(threads),
            adaptive: params.adapts_penalties(),
            ..Self::of(params.quads(), per_subgroup, subgroup, features.contains(wgpu::Features::SHADER_INT64))
        }
    }

    /// Of `lines` rows or paths of `bytes` each, those that are worked on at a time, for about `most` bytes.
    pub(crate) fn strip(&self, lines: u32, bytes: u64, most: u64) -> u32 {
        let Some(threads) = self.threads else { return lines };
        let unit = 2 * STRIP_LANES * threads;
        let fit = (most / bytes).min(lines.into()) as u32;
        (fit / unit * unit).max(unit).max(lines.div_ceil(MOST_STRIPS)).min(lines)
    }

    /// The most bytes that a strip of at most so many lines and bytes takes.
    pub(crate) fn strip_room(&self, lines: u32, bytes: u64, most: u64) -> u64 {
        let Some(threads) = self.threads else { return u64::from(lines) * bytes };
        let least = (2 * STRIP_LANES * threads).max(lines.div_ceil(MOST_STRIPS));
        most.max(u64::from(least) * bytes).min(u64::from(lines) * bytes)
    }

    /// The plan for pixels of `quads` vectors, where `subgroup` neighbours can exchange values (at most 1: none can), with or
    /// without integers of 64 bits.
    pub(crate) fn of(quads: u32, per_subgroup: bool, subgroup: u32, int64: bool) -> Self {
        // Members lie in one workgroup.
        let group = if per_subgroup { GROUP_LANES } else { STRIP_LANES };
        let neighbours = subgroup.min(group);
        // More invocations may share a path through workgroup memory than through a small subgroup.
        let own = quads.div_ceil(neighbours.max(1));
        let few = own <= MOST_GROUP_QUADS || neighbours >= MOST_MEMBERS && own <= MOST_TRIPS;
        let exchange = match neighbours > 1 && if per_subgroup { few } else { own <= MOST_TRIPS } {
            true => Exchange::Subgroup,
            false if per_subgroup || quads > MOST_TRIPS => Exchange::Workgroup,
            false => Exchange::Alone,
        };
        let most_members = match exchange {
            Exchange::Alone => 1,
            Exchange::Subgroup => neighbours,
            Exchange::Workgroup => MOST_MEMBERS.min(group),
        };
        let most_quads = match exchange {
            _ if per_subgroup => 1,
            Exchange::Workgroup => MOST_TRIPS,
            _ => MOST_QUADS,
        };
        let mut members = 1;
        while quads.div_ceil(members) > most_quads && 2 * members <= most_members {
            members *= 2;
        }
        let wide = int64 && !per_subgroup && quads.is_multiple_of(2);
        let width = if wide { 2 } else { 1 };
        Self {
            per_subgroup,
            members,
            exchange: if members == 1 { Exchange::Alone } else { exchange },
            own_quads: quads.div_ceil(members).next_multiple_of(width),
            width,
            subgroup,
            threads: None,
            adaptive: false,
            part_bits: None,
        }
    }
}

/// Rows that one invocation of `cost_columns` or `matching_cost_parallel` walks. What the rows before the first one cost is lost,
/// but a GPU wants many invocations.
pub(crate) fn segment(plan: &Plan) -> u32 {
    if plan.per_subgroup { 32 } else { 128 }
}

/// Rows of a column that one invocation of `cost_columns_features` sums: as few as its rounds allow, with checks of every loop.
pub(crate) const FEATURE_SEGMENT: u32 = 16;

/// Vectors of 16 disparities that one invocation of `cost_columns` owns: a divisor of all. More of them load a right pixel
/// less often, but make code that grows with them.
pub(crate) fn vectors(quads: u32, plan: &Plan) -> u32 {
    let most = if plan.per_subgroup { 1 } else { 4 };
    (1..=most).rev().find(|&vectors| quads.is_multiple_of(vectors)).unwrap_or(1)
}

/// Groups of eight channels that an invocation of the layers of a network of features computes. On a CPU more of them spare loads.
pub(crate) fn groups(plan: &Plan) -> u32 {
    if plan.per_subgroup { 1 } else { 2 }
}

/// Columns that one invocation of `matching_cost` walks: for a CPU any row that may be.
pub(crate) fn span(plan: &Plan) -> u32 {
    if plan.per_subgroup { 64 } else { 1 << 16 }
}

/// Invocations of `block_match_small` that share the disparities of a row, and rows that they walk.
pub(crate) fn parts_and_strip(disparities: u32) -> (u32, u32) {
    let parts = disparities.div_ceil(16).next_power_of_two().min(8);
    (parts, if disparities <= 16 * parts { 16 } else { 8 })
}

/// Bytes that the penalties of a step take: of P2, or of P2 and P1.
pub(crate) fn penalty_bytes(params: &Params) -> u32 {
    if params.adaptive_p1 { 2 } else { 1 }
}

/// Volumes that hold the paths which cross rows, two directions each.
pub(crate) fn paired(paths: Paths) -> u32 {
    (paths.count() - 1) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Members lie in one workgroup and in one subgroup, own all disparities, and no more than loops are unrolled for.
    #[test]
    fn plans_fit_their_workgroups() {
        for quads in 1..=256 {
            for subgroup in [1, 4, 8, 16, 32, 64, 128] {
                for (per_subgroup, int64) in [(false, false), (false, true), (true, false), (true, true)] {
                    let plan = Plan::of(quads, per_subgroup, subgroup, int64);
                    let group = if per_subgroup { GROUP_LANES } else { STRIP_LANES };
                    assert!(group.is_multiple_of(plan.members), "{quads} {plan:?}");
                    assert!(plan.exchange != Exchange::Subgroup || plan.members <= subgroup, "{quads} {plan:?}");
                    assert!(plan.exchange != Exchange::Alone || plan.members == 1, "{quads} {plan:?}");
                    assert!(plan.members * plan.own_quads >= quads, "{quads} {plan:?}");
                    assert!(plan.own_quads <= MOST_TRIPS, "{quads} {plan:?}");
                    assert!(plan.own_quads.is_multiple_of(plan.width) && quads.is_multiple_of(plan.width), "{plan:?}");
                }
            }
        }
    }
}
