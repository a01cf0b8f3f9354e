//! How volumes are cut: into bands of rows, bands into pieces, pieces into chunks.

use crate::gpu::layout::features::FeatureSizes;
use crate::gpu::layout::request::{FEWER, ROW_UNIT, Request, Strides};
use crate::gpu::layout::rows::{Rows, cut, cut_to};
use crate::gpu::layout::scales::{WAYS, band_unit};
use crate::gpu::layout::uniforms::TEXTURE_ROW;
use crate::gpu::plan::paired;
use crate::gpu::rounds::MOST_SIDE;
use crate::{Error, Method};

/// Bytes a buffer of column sums may take. They live only until the cost is computed from them, so more of them than
/// keeps a device busy is a waste of memory.
const COLUMNS_BYTES: u64 = 32 << 20;

/// Buffers of a band that hold the paths which cross rows.
pub(crate) const PAIR_BUFFERS: usize = 3;

/// The most disparities that `block_match_small` takes: 32 for each of 8 slices.
const MOST_SLICED: u32 = 256;

/// Rows of a band whose cost is computed from planes that are held at one time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    /// The rows whose cost is made.
    pub(crate) rows: Rows,
    /// The rows that the planes hold: those, and the rows that their blocks reach.
    pub(crate) planes: Rows,
    /// The rows whose column sums are held at one time; none if `small_block`.
    pub(crate) chunks: Vec<Rows>,
}

/// How everything with a value for each disparity is cut.
#[derive(Clone, Debug)]
pub(super) struct Division {
    pub(super) volume_row: u64,
    pub(super) columns_row: u64,
    pub(super) statistics_row: u64,
    pub(super) columns_room: u64,
    pub(super) bands: Vec<Rows>,
    pub(super) pieces: Vec<Vec<Piece>>,
    pub(super) small_block: bool,
    pub(super) planes_rows: u32,
}

/// What was made for larger images, and is used for smaller ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Former {
    /// Bytes of one volume of the first band.
    pub(super) band_bytes: u64,
    pub(super) small_block: bool,
    pub(super) planes_rows: u32,
}

impl Division {
    /// `right_map`: bytes of the right view's map and of what follows it.
    pub(super) fn new(
        request: &Request<'_>,
        strides: &Strides,
        right_map: u64,
        former: Option<Former>,
    ) -> Result<Self, Error> {
        let Request { width, height, params, .. } = *request;
        let (allowed, reach, words) = (request.binding(), 2 * params.radius(), 4 * params.quads());
        let volume_row = 4 * u64::from(strides.volume) * u64::from(words);
        let sum_bytes = if params.wide_sums() { 4 } else { 2 };
        let columns_row = 4 * sum_bytes * u64::from(width + reach) * u64::from(words);
        let statistics_row = 8 * u64::from(2 * width + params.disparities - 1);
        let chunk_row = columns_row.max(if params.correlates() { statistics_row } else { 0 });
        let bands = bands(request, volume_row, former)?;
        let small_block = sums_small_blocks(request, strides, former);
        if !small_block {
            request.fits("a row of column sums", chunk_row, FEWER)?;
        }
        // A column's first row costs as much as a block of rows: short chunks are slow.
        let chunk_bytes = COLUMNS_BYTES.max(128 * chunk_row).min(allowed);
        // A block reaches `margin` rows beyond its own; the row before leaves its sum.
        let (planes, margin) = (params.compared_planes().max(1), params.radius() + 1);
        let mut planes_row = 4 * u64::from(planes) * u64::from(strides.left.max(strides.right));
        let mut planes_rows = (allowed / planes_row).min(height.into()) as u32;
        match params.feature_network() {
            Some(network) => {
                let (rows, row) = FeatureSizes::most_rows(request, &network);
                (planes_rows, planes_row) = (planes_rows.min(rows), planes_row.max(row));
            }
            None if small_block && !request.plan.per_subgroup => {
                planes_rows = planes_rows.min(request.limits.max_texture_dimension_2d / planes);
            }
            None => {}
        }
        planes_rows = former.map_or(planes_rows, |former| planes_rows.min(former.planes_rows));
        // Block matching may leave a piece's rows of the maps at once.
        let map_row = 4 * u64::from(strides.map);
        let map_rows = if right_map <= allowed { height } else { (allowed / map_row - ROW_UNIT + 1) as u32 };
        let most_rows =
            if planes_rows == height { height } else { planes_rows.saturating_sub(2 * margin) }.min(map_rows);
        if most_rows == 0 {
            let needed = planes_row * u64::from(2 * margin + 1);
            return Err(Error::TooLarge { what: "what costs compare of a row".into(), needed, allowed, remedy: FEWER });
        }
        let piece = |rows: Rows| {
            let first = rows.first.saturating_sub(margin);
            let planes = match planes_rows == height {
                true => Rows { first: 0, count: height },
                false => Rows { first, count: (rows.end() + margin).min(height) - first },
            };
            let chunks = if small_block { vec![] } else { cut(rows, most(request, chunk_bytes, chunk_row)) };
            Piece { rows, planes, chunks }
        };
        let pieces = bands.iter().map(|&band| cut(band, most_rows).into_iter().map(piece).collect()).collect();
        let columns_room = chunk_bytes.min(u64::from(height) * chunk_row);
        Ok(Self { volume_row, columns_row, statistics_row, columns_room, bands, pieces, small_block, planes_rows })
    }
}

/// Rows of `row` bytes in `bytes`.
fn most(request: &Request<'_>, bytes: u64, row: u64) -> u32 {
    (bytes / row).clamp(1, u64::from(request.height)) as u32
}

/// The bands of a volume: none is larger than a binding may be, nor than what was made for larger images.
fn bands(request: &Request<'_>, volume_row: u64, former: Option<Former>) -> Result<Vec<Rows>, Error> {
    let Request { width, height, params, limits, .. } = *request;
    let (words, side) = (4 * params.quads(), request.most_side());
    // What is copied into a texture is made of whole rows of it.
    let allowed = (request.binding() / TEXTURE_ROW).min(limits.max_texture_dimension_2d.into()) * TEXTURE_ROW;
    // A buffer holds as many volumes, one after the other.
    let slots = match params.method {
        Method::Bp => u64::from(WAYS),
        Method::Sgm | Method::Bm | Method::Psmnet => u64::from(paired(params.paths)).div_ceil(PAIR_BUFFERS as u64),
    };
    let unit = band_unit(params, width, height);
    let needed = (u64::from(unit.min(height)) * slots * volume_row).next_multiple_of(TEXTURE_ROW);
    if params.method == Method::Bp && needed > allowed {
        let (what, remedy) =
            ("a pass of messages over a few rows".into(), "use fewer disparities, narrower images or fewer levels");
        return Err(Error::TooLarge { what, needed, allowed, remedy });
    }
    if params.method.quantises() && needed > allowed {
        return Err(Error::TooLarge { what: "a row of the matching cost".into(), needed, allowed, remedy: FEWER });
    }
    // An invocation a column and 16 disparities, 128 a workgroup.
    let most_vectors = 128 * u64::from(side);
    if u64::from(width + 2 * params.radius()) * u64::from(words / 4) > most_vectors {
        let (what, needed, allowed) = ("a row of the matching cost".into(), volume_row, 16 * most_vectors);
        return Err(Error::TooLarge { what, needed, allowed, remedy: FEWER });
    }
    let whole = Rows { first: 0, count: height };
    Ok(match params.method {
        // `matching_cost_small` has an invocation for two rows and 16 disparities, 32 a workgroup.
        Method::Sgm | Method::Bp => {
            let room = former.map_or(allowed, |former| slots * former.band_bytes);
            let rows = most(request, room.min(allowed), slots * volume_row);
            let rows = rows.min(side.saturating_mul(64) / (words / 4));
            if rows >= height { vec![whole] } else { cut_to(whole, rows.max(unit), unit) }
        }
        Method::Bm | Method::Psmnet => vec![whole],
    })
}

/// Whether a kernel for small blocks is used, from planes in textures and without column sums.
fn sums_small_blocks(request: &Request<'_>, strides: &Strides, former: Option<Former>) -> bool {
    let Request { params, limits, plan, .. } = *request;
    let method = match params.method {
        Method::Sgm | Method::Bp => true,
        // Not with the checks, which keep the loops over an invocation's state from being unrolled.
        Method::Psmnet => false,
        Method::Bm => {
            !plan.per_subgroup
                && plan.subgroup >= 8
                && !params.shader_checks
                && params.disparities <= MOST_SLICED
                && params.cost.row().small_match
                && params.planes() == 1
                && params.prefiltered_max() < 128
                && !params.confidence
        }
    };
    let kernel = match (params.method, plan.per_subgroup, params.block) {
        (Method::Bm | Method::Psmnet, ..) => "block_match_small",
        _ if params.takes_features() => "matching_cost_features",
        (Method::Sgm | Method::Bp, true, _) => "matching_cost_parallel",
        (Method::Sgm | Method::Bp, false, 1) => "matching_cost_pixels",
        (Method::Sgm | Method::Bp, false, _) => "matching_cost_small",
    };
    method
        && former.is_none_or(|former| former.small_block)
        && params.sums_small_blocks()
        && request.takes(kernel, MOST_SIDE)
        && strides.left.max(strides.right) <= limits.max_texture_dimension_2d
}
