//! Sizes, strides and usages of every buffer, computed in one place before anything is created.

use crate::schedule::Plan;
use crate::{Cost, Error, Fill, Method, Params, PixelFormat, kernels, reference, rounds};

/// The WGSL block `Frame`: what stays the same for all dispatches of a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Frame {
    pub(crate) width: u32,
    pub(crate) height: u32,
    pub(crate) min_disparity: i32,
    pub(crate) block_radius: u32,
    pub(crate) prefilter_cap: u32,
    pub(crate) cost_scale: u32,
    pub(crate) p1: u32,
    pub(crate) p2: u32,
    pub(crate) lr_max_difference: u32,
    pub(crate) gray_stride: u32,
    pub(crate) left_stride: u32,
    pub(crate) right_stride: u32,
    pub(crate) map_stride: u32,
    pub(crate) volume_stride: u32,
    pub(crate) map_words: u32,
    pub(crate) texture: u32,
    pub(crate) speckle_window: u32,
    pub(crate) speckle_range: i32,
    pub(crate) fill_max_difference: i32,
    pub(crate) depth_high: u32,
    pub(crate) depth_low: u32,
    pub(crate) depth_offset: i32,
}

/// The WGSL block `Pass`: what differs between dispatches.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Pass {
    pub(crate) first_row: u32,
    pub(crate) rows: u32,
    pub(crate) volume_row: u32,
    pub(crate) first_line: u32,
    pub(crate) lines: u32,
    pub(crate) shift: u32,
    pub(crate) dx: i32,
    pub(crate) dy: i32,
    pub(crate) carried: u32,
    pub(crate) accumulate: u32,
    pub(crate) channel: u32,
    pub(crate) mirrored: u32,
    pub(crate) lead: i32,
    pub(crate) stride: u32,
    pub(crate) first_plane: u32,
    pub(crate) window: u32,
    pub(crate) row_step: u32,
    pub(crate) occlusions: u32,
    pub(crate) reversed: u32,
    pub(crate) entry: i32,
    pub(crate) carry_from: u32,
    pub(crate) carry_to: u32,
    pub(crate) slot: u32,
    pub(crate) penalties_from: u32,
    pub(crate) penalties_line: u32,
    pub(crate) penalties_step: u32,
    pub(crate) place: i32,
    pub(crate) halvings: u32,
    pub(crate) narrowing: u32,
    pub(crate) prior: u32,
    pub(crate) logarithms: u32,
    pub(crate) side: u32,
}

/// Neighbouring rows that are worked on together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rows {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// The longest side that is taken: a row and the smallest disparity take a round a pixel ([`rounds`]).
pub(crate) const MOST_SIDE: u32 = 60_000;

/// Groups of eight columns that are joined across a border of two bands at a time, so that no way to a root is long ([`rounds`]).
pub(crate) const SEGMENT_GROUPS: u32 = 128;

/// Bytes a buffer of column sums may take. They live only until the cost is computed from them, so more of them than
/// keeps a device busy is a waste of memory.
const COLUMNS_BYTES: u64 = 32 << 20;

/// Texels of 16 bytes in a row of the textures that hold a copy of a buffer, which are filled line by line.
pub(crate) const TEXELS: u32 = 1024;

/// Buffers of a band that hold the paths which cross rows.
pub(crate) const PAIR_BUFFERS: usize = 3;

/// Bytes of a row of [`TEXELS`].
pub(crate) const TEXTURE_ROW: u64 = 16 * TEXELS as u64;

/// The most disparities that `block_match_small` takes: 32 for each of 8 slices.
const MOST_SLICED: u32 = 256;

/// The sizes of everything. A volume is cut into bands of rows, each in a buffer of its own, none larger than one
/// storage binding may be; column sums are computed for one chunk of a band at a time.
#[derive(Clone, Debug)]
pub(crate) struct Sizes {
    pub(crate) frame: Frame,
    /// As [`source_bytes`].
    pub(crate) source: u64,
    pub(crate) gray: u64,
    /// Bytes of a 32-bit number for each pixel.
    pub(crate) sums: u64,
    pub(crate) left: u64,
    pub(crate) right: u64,
    /// Bytes of one disparity map.
    pub(crate) map: u64,
    /// Bytes of the penalties of a direction.
    pub(crate) penalties: u64,
    /// Bytes of the right view's map, and of the margins behind it if a confidence is wanted.
    pub(crate) right_map: u64,
    /// Bytes of the confidence.
    pub(crate) confidence: u64,
    /// Bytes of one number of 32 bits a pixel of a map.
    pub(crate) regions: u64,
    /// Bytes of the nearest values on both sides of each pixel.
    pub(crate) nearest: u64,
    /// Bytes of a row of a volume with a byte a disparity.
    pub(crate) volume_row: u64,
    /// Bytes of a row of column sums.
    pub(crate) columns_row: u64,
    /// Bytes of a row of the statistics of blocks.
    pub(crate) statistics_row: u64,
    pub(crate) bands: Vec<Rows>,
    /// The most bytes that column sums, or the statistics of blocks, take here or in a smaller image.
    pub(crate) columns_room: u64,
    /// Whether `matching_cost_small` or `block_match_small` is used, from planes in textures and without column sums.
    pub(crate) small_block: bool,
    /// The chunks of each band; none if `small_block`.
    pub(crate) chunks: Vec<Vec<Rows>>,
}

/// Bytes of the texture of one uploaded image: 256 more than it has may be read.
pub(crate) fn source_bytes(width: u32, height: u32, format: PixelFormat) -> u64 {
    let pixels = u64::from(width) * u64::from(height);
    (pixels * u64::from(format.bytes_per_pixel()) + 256).next_multiple_of(TEXTURE_ROW)
}

/// Cuts `rows` into the fewest pieces of at most `most` rows, as even as can be.
pub(crate) fn cut(rows: Rows, most: u32) -> Vec<Rows> {
    let pieces = rows.count.div_ceil(most);
    let count = rows.count.div_ceil(pieces);
    let firsts = (0..pieces).map(|i| rows.first + i * count);
    let end = rows.first + rows.count;
    firsts.filter(|&first| first < end).map(|first| Rows { first, count: count.min(end - first) }).collect()
}

impl Sizes {
    /// Bytes of the buffer of a volume of `rows` rows: whole rows of the texture.
    pub(crate) fn volume(&self, rows: u32) -> u64 {
        (u64::from(rows) * self.volume_row).next_multiple_of(TEXTURE_ROW)
    }

    /// The sizes for images of `width` x `height` pixels; `largest` are those for larger ones: what was made for these does for
    /// the smaller ones.
    pub(crate) fn new(
        width: u32,
        height: u32,
        format: PixelFormat,
        params: &Params,
        limits: &wgpu::Limits,
        plan: &Plan,
        largest: Option<&Self>,
    ) -> Result<Self, Error> {
        let allowed = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let fits = |what: &str, needed: u64, remedy| {
            if needed <= allowed { Ok(()) } else { Err(Error::TooLarge { what: what.into(), needed, allowed, remedy }) }
        };
        let side = limits.max_compute_workgroups_per_dimension.min(MOST_SIDE);
        if width > side || height > side {
            return Err(Error::Image(format!(
                "the images are {width}x{height}, but at most {side} pixels a side are possible here; make them smaller"
            )));
        }
        let taken = |kernel, side: u32| {
            let rounds = rounds::rounds(kernel, params, [width.min(side), height.min(side)], plan);
            rounds.is_none_or(|rounds| rounds <= rounds::MOST)
        };
        let walks: &[&str] = if params.method == Method::Sgm { &["sgm_aggregate", "winner"] } else { &["block_match"] };
        let all_taken = |side: &u32| walks.iter().all(|kernel| taken(kernel, *side));
        if !all_taken(&MOST_SIDE) {
            let most = (1..width.max(height)).rev().find(all_taken).unwrap_or(0);
            return Err(Error::Image(format!(
                "the images are {width}x{height}, but with shader checks at most {most} pixels a side are possible with these \
                 settings; switch the checks off or make the images smaller"
            )));
        }
        let pixels = u64::from(width) * u64::from(height);
        let smaller = "make the images smaller";

        let words = 4 * params.disparities.div_ceil(16);
        let reach = 2 * params.radius();
        // Sixteen columns before the image; three vectors are read from the one before the last column on.
        let gray_stride = (width + 14) / 16 + 3;
        // Rows of the planes are copied into textures: 256 bytes are the unit of that.
        let left_stride = (width + reach).div_ceil(4).next_multiple_of(64);
        let right_stride = ((width - 1 + reach) / 4 + words + 1).next_multiple_of(64);
        let map_stride = 4 * width.div_ceil(8);
        let rows = |stride: u32| 4 * u64::from(stride) * u64::from(height);
        let texels = |stride: u32| rows(stride).next_multiple_of(TEXTURE_ROW);
        let planes = u64::from(params.planes());
        fits("what costs compare of an image", planes * rows(left_stride.max(right_stride)), smaller)?;

        if params.cost == Cost::MutualInformation {
            fits("the histogram of all pairs of values", 4 * 256 * 256, "take another cost")?;
        }
        if params.sums_windows() {
            fits("the sums over windows", 4 * pixels, smaller)?;
        }

        // Rows an even number of pixels apart may share a few places of a cache.
        let volume_stride = width | 1;
        let volume_row = 4 * u64::from(volume_stride) * u64::from(words);
        let sum_bytes = if params.wide_sums() { 4 } else { 2 };
        let columns_row = 4 * sum_bytes * u64::from(width + reach) * u64::from(words);
        let statistics_row = 8 * u64::from(2 * width + params.disparities - 1);
        let chunk_row = columns_row.max(if params.cost == Cost::Ncc { statistics_row } else { 0 });
        // What is copied into a texture is made of whole rows of it.
        let texture_rows = (allowed / TEXTURE_ROW).min(limits.max_texture_dimension_2d.into());
        let volume_allowed = texture_rows * TEXTURE_ROW;
        let source = source_bytes(width, height, format);
        let source_allowed = TEXTURE_ROW * u64::from(limits.max_texture_dimension_2d); // a texture alone
        for (what, needed, allowed) in [
            ("an image", source, source_allowed),
            ("a gray image", texels(if format.is_deep() { 8 } else { 4 } * gray_stride), volume_allowed),
            ("a disparity map", texels(map_stride), volume_allowed),
        ] {
            if needed > allowed {
                return Err(Error::TooLarge { what: what.into(), needed, allowed, remedy: smaller });
            }
        }
        // The place behind the last one is read, too.
        let (across, along) = (width * 2 * (height.div_ceil(2) / 16 + 1), (width / 16 + 1) * height);
        let penalties = 16 * u64::from(across.max(along));
        if plan.adaptive {
            fits("the penalties of the pixels", penalties, "make the images smaller or switch adaptive_p2 off")?;
        }
        let map = texels(map_stride);
        let right_map = if params.confidence { 2 * map } else { map };
        fits("a disparity map with its confidence", right_map, smaller)?;
        if params.wls.is_some() {
            fits("a map of two numbers a pixel", 8 * u64::from(volume_stride) * u64::from(height), smaller)?;
        }
        let regions = 2 * texels(map_stride);
        if params.rectify.is_some() {
            fits("a rectified image", source, smaller)?;
            fits("where rectified pixels come from", 8 * pixels, smaller)?;
        }
        if params.depth.is_some() {
            fits("a depth map", regions, smaller)?;
        }
        if params.speckle_window > 0 {
            fits("the regions of the speckle filter", regions, "make the images smaller or switch the filter off")?;
        }
        let nearest = 32 * u64::from(map_stride / 4 + 1) * u64::from(height);
        if params.fill != Fill::None {
            fits("what the holes are filled with", nearest, "make the images smaller or leave the holes")?;
        }
        let fewer = "use fewer disparities or narrower images";
        // A buffer holds as many volumes, one after the other.
        let slots = u64::from(kernels::paired(params.paths)).div_ceil(PAIR_BUFFERS as u64);
        let volume_needs = (slots * volume_row).next_multiple_of(TEXTURE_ROW);
        if params.method == Method::Sgm && volume_needs > volume_allowed {
            let what = "a row of the matching cost".into();
            return Err(Error::TooLarge { what, needed: volume_needs, allowed: volume_allowed, remedy: fewer });
        }
        // An invocation a column and 16 disparities, 128 a workgroup.
        let most_vectors = 128 * u64::from(side);
        if u64::from(width + reach) * u64::from(words / 4) > most_vectors {
            let (what, needed, allowed) = ("a row of the matching cost".into(), volume_row, 16 * most_vectors);
            return Err(Error::TooLarge { what, needed, allowed, remedy: fewer });
        }
        // A column's first row costs as much as a block of rows: short chunks are slow.
        let chunk_bytes = COLUMNS_BYTES.max(128 * chunk_row).min(allowed);
        let most = |bytes: u64, row: u64| (bytes / row).clamp(1, u64::from(height)) as u32;
        let whole = Rows { first: 0, count: height };
        let bands = match params.method {
            // `matching_cost_small` has an invocation for two rows and 16 disparities, 32 a workgroup.
            Method::Sgm => {
                let room = largest.map_or(volume_allowed, |largest| {
                    let rows = largest.bands.first().map_or(1, |band| band.count);
                    slots * u64::from(rows) * largest.volume_row
                });
                cut(
                    whole,
                    most(room.min(volume_allowed), slots * volume_row).min(side.saturating_mul(64) / (words / 4)),
                )
            }
            Method::Bm => vec![whole],
        };
        let small_method = match params.method {
            Method::Sgm => true,
            // Not with the checks, which keep the loops over an invocation's state from being unrolled.
            Method::Bm => {
                !plan.lanes
                    && plan.subgroup >= 8
                    && !params.shader_checks
                    && params.disparities <= MOST_SLICED
                    && params.cost == Cost::Sad
                    && params.planes() == 1
                    && params.prefiltered_max() < 128
                    && !params.confidence
            }
        };
        let small_kernel = match (params.method, plan.lanes, params.block) {
            (Method::Bm, ..) => "block_match_small",
            (Method::Sgm, true, _) => "matching_cost_lanes",
            (Method::Sgm, false, 1) => "matching_cost_pixels",
            (Method::Sgm, false, _) => "matching_cost_small",
        };
        let small_block = small_method
            && largest.is_none_or(|largest| largest.small_block)
            && params.sums_small_blocks()
            && taken(small_kernel, MOST_SIDE)
            && left_stride.max(right_stride).max(height * params.planes()) <= limits.max_texture_dimension_2d;
        if !small_block {
            fits("a row of column sums", chunk_row, fewer)?;
        }
        let chunks_of = |&band: &Rows| if small_block { vec![] } else { cut(band, most(chunk_bytes, chunk_row)) };
        let (product, depth_offset) = params.depth.map_or((0, 0), |camera| camera.fixed());
        let chunks = bands.iter().map(chunks_of).collect();
        Ok(Self {
            frame: Frame {
                width,
                height,
                min_disparity: params.min_disparity,
                block_radius: params.radius(),
                prefilter_cap: params.prefilter_cap,
                cost_scale: reference::matching_cost_scale(params),
                p1: params.p1,
                p2: params.p2,
                lr_max_difference: params.lr_check.unwrap_or(0),
                gray_stride,
                left_stride,
                right_stride,
                map_stride,
                volume_stride,
                map_words: (map / 4) as u32,
                texture: params.texture,
                speckle_window: params.speckle_window,
                speckle_range: 16 * params.speckle_range as i32,
                fill_max_difference: params.lr_check.unwrap_or(1) as i32,
                depth_high: (product >> 32) as u32,
                depth_low: product as u32,
                depth_offset,
            },
            source,
            gray: texels(4 * gray_stride),
            sums: 4 * pixels,
            left: planes * rows(left_stride),
            right: planes * rows(right_stride),
            map,
            right_map,
            confidence: map / 2,
            regions,
            nearest,
            penalties,
            volume_row,
            columns_row,
            statistics_row,
            bands,
            columns_room: chunk_bytes.min(u64::from(height) * chunk_row),
            small_block,
            chunks,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_all_rows_once() {
        for count in 1..40 {
            for most in 1..45 {
                let pieces = cut(Rows { first: 3, count }, most);
                let mut next = 3;
                for piece in &pieces {
                    assert_eq!(piece.first, next);
                    assert!(piece.count >= 1 && piece.count <= most);
                    next += piece.count;
                }
                assert_eq!(next, 3 + count);
                assert_eq!(pieces.len() as u32, count.div_ceil(most), "{count} rows in pieces of {most}");
            }
        }
    }

    /// A dispatch has at most so many workgroups a side: wide images with many disparities are refused, high ones cut.
    #[test]
    fn no_dispatch_is_too_large() {
        let limits = wgpu::Limits { max_compute_workgroups_per_dimension: 1024, ..Default::default() };
        let params = |disparities| Params { min_disparity: -2047, ..Params::sgm(disparities) };
        let sizes = |width, height, disparities| {
            let params = params(disparities);
            let plan = Plan::of(params.quads(), false, 1, false);
            Sizes::new(width, height, PixelFormat::Gray8, &params, &limits, &plan, None)
        };
        assert!(sizes(1000, 10, 2048).is_ok());
        assert!(matches!(sizes(1000, 10, 4095), Err(Error::TooLarge { .. })));
        let bands = sizes(3, 1000, 4095).map(|sizes| sizes.bands);
        let most = bands.iter().flatten().map(|band| band.count.div_ceil(2) * 256).max();
        assert!(most.is_some_and(|invocations| invocations <= 32 * 1024), "{bands:?}");
    }
}
