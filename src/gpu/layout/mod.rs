//! Sizes, strides and usages of every buffer, computed in one place before anything is created.

use crate::gpu::plan::Plan;
use crate::gpu::{kernels, rounds};
use crate::{Cost, Error, Fill, Method, Params, PixelFormat, reference};

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
    pub(crate) source_shift: u32,
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
    pub(crate) map_row: u32,
    pub(crate) planes_row: u32,
    pub(crate) planes_rows: u32,
}

/// Neighbouring rows that are worked on together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rows {
    pub(crate) first: u32,
    pub(crate) count: u32,
}

impl Rows {
    /// The row behind the last one.
    pub(crate) fn end(self) -> u32 {
        self.first + self.count
    }
}

/// Rows of a band whose cost is made from planes that are there at one time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    /// The rows whose cost is made.
    pub(crate) rows: Rows,
    /// The rows that the planes hold: those, and what their blocks reach.
    pub(crate) planes: Rows,
    /// The rows whose column sums are there at one time; none if `small_block`.
    pub(crate) chunks: Vec<Rows>,
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

/// Parts of one binding each that the trees of the speckle filter may be cut into.
pub(crate) const MOST_PARTS: u32 = 4;

/// Rows of a map or an image, a multiple of which begin where a binding may: at a multiple of 256 bytes, of rows that are
/// a multiple of 4.
pub(crate) const ROW_UNIT: u64 = 64;

/// The sizes of everything. A volume is cut into bands of rows, each in a buffer of its own, none larger than one
/// storage binding may be; planes are made for a piece of a band at a time, and column sums for a chunk of that. A map
/// or an image is one buffer, of which kernels are bound to as many rows as a binding may hold.
#[derive(Clone, Debug)]
pub(crate) struct Sizes {
    pub(crate) frame: Frame,
    /// The most bytes of a buffer that one binding may hold.
    pub(crate) binding: u64,
    /// As [`source_layout`]: texels a row, and bytes.
    pub(crate) source_texels: u32,
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
    /// Rows that the planes hold at a time.
    pub(crate) planes_rows: u32,
    /// The pieces of each band.
    pub(crate) pieces: Vec<Vec<Piece>>,
    /// Bits of the number of a pixel in its part, if the trees of the speckle filter need more than one binding.
    pub(crate) part_bits: Option<u32>,
}

/// Bytes of one uploaded image, and 256 more, which may be read.
fn source_bytes(width: u32, height: u32, format: PixelFormat) -> u64 {
    u64::from(width) * u64::from(height) * u64::from(format.bytes_per_pixel()) + 256
}

/// Texels a row of the texture of one uploaded image, [`TEXELS`] if so many rows do as a texture may have, and its bytes.
pub(crate) fn source_layout([width, height]: [u32; 2], format: PixelFormat, limits: &wgpu::Limits) -> (u32, u64) {
    let bytes = source_bytes(width, height, format);
    let most = limits.max_texture_dimension_2d;
    let mut texels = TEXELS;
    while bytes > 16 * u64::from(texels) * u64::from(most) && 2 * texels <= most {
        texels *= 2;
    }
    (texels, bytes.next_multiple_of(16 * u64::from(texels)))
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
        // Kernels are bound to some rows of it, or to all.
        let rows_fit = |what: &str, row: u64, remedy| {
            let all = row * u64::from(height);
            let (needed, allowed) = match all <= limits.max_buffer_size {
                true => (all.min(ROW_UNIT * row), allowed),
                false => (all, limits.max_buffer_size),
            };
            if needed <= allowed { Ok(()) } else { Err(Error::TooLarge { what: what.into(), needed, allowed, remedy }) }
        };
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
        let texture_rows = u64::from(limits.max_texture_dimension_2d);
        let [volume_allowed, image_allowed] =
            [allowed, limits.max_buffer_size].map(|most| (most / TEXTURE_ROW).min(texture_rows) * TEXTURE_ROW);
        let (source_texels, source) = match largest {
            Some(largest) => {
                let texels = largest.source_texels;
                (texels, source_bytes(width, height, format).next_multiple_of(16 * u64::from(texels)))
            }
            None => source_layout([width, height], format, limits),
        };
        let source_allowed = 16 * u64::from(source_texels) * texture_rows; // a texture alone
        let gray_row = 16 * u64::from(gray_stride) * if format.is_deep() { 2 } else { 1 };
        let map_row = 4 * u64::from(map_stride);
        let whole_rows = |row: u64| (row * u64::from(height)).next_multiple_of(TEXTURE_ROW);
        for (what, needed, allowed) in [
            ("an image", source, source_allowed),
            ("a gray image", whole_rows(gray_row), image_allowed),
            ("a disparity map", whole_rows(map_row), image_allowed),
        ] {
            if needed > allowed {
                return Err(Error::TooLarge { what: what.into(), needed, allowed, remedy: smaller });
            }
        }
        rows_fit("rows of a gray image", gray_row, smaller)?;
        rows_fit("rows of a disparity map", map_row, smaller)?;
        // The place behind the last one is read, too.
        let (across, along) = (width * 2 * (height.div_ceil(2) / 16 + 1), (width / 16 + 1) * height);
        let penalties = 16 * u64::from(across.max(along));
        if plan.adaptive {
            fits("the penalties of the pixels", penalties, "make the images smaller or switch adaptive_p2 off")?;
        }
        let map = texels(map_stride);
        if params.cost == Cost::MutualInformation {
            fits(
                "a disparity map for the histogram of mutual information",
                map,
                "make the images smaller or take another cost",
            )?;
        }
        let right_map = if params.confidence { 2 * map } else { map };
        if params.confidence {
            fits("a disparity map with its confidence", right_map, "make the images smaller or leave the confidence")?;
        }
        if params.wls.is_some() {
            rows_fit("rows of two numbers a pixel", 8 * u64::from(volume_stride), smaller)?;
        }
        let regions = 2 * texels(map_stride);
        if params.rectify.is_some() {
            fits("a rectified image", source, smaller)?;
            fits("where rectified pixels come from", 8 * pixels, smaller)?;
        }
        if params.depth.is_some() {
            rows_fit("rows of a depth map", 2 * map_row, smaller)?;
        }
        let part_bits = (regions > allowed).then(|| (allowed / 4).ilog2());
        let parts = part_bits.map_or(1, |bits| regions.div_ceil(4 << bits));
        if params.speckle_window > 0 {
            rows_fit("rows of the regions of the speckle filter", 2 * map_row, smaller)?;
        }
        if params.speckle_window > 0 && (parts > MOST_PARTS.into() || regions > limits.max_buffer_size) {
            return Err(Error::TooLarge {
                what: "the regions of the speckle filter".into(),
                needed: regions,
                allowed: limits.max_buffer_size.min(u64::from(MOST_PARTS) * (4 << part_bits.unwrap_or(0))),
                remedy: "make the images smaller or switch the filter off",
            });
        }
        let nearest_row = 32 * u64::from(map_stride / 4 + 1);
        let nearest = nearest_row * u64::from(height);
        if params.fill != Fill::None {
            rows_fit(
                "rows of what the holes are filled with",
                nearest_row,
                "make the images smaller or leave the holes",
            )?;
            fits("the occlusions", map_row / 4 * u64::from(height), "make the images smaller or leave the holes")?;
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
                !plan.per_subgroup
                    && plan.subgroup >= 8
                    && !params.shader_checks
                    && params.disparities <= MOST_SLICED
                    && params.cost == Cost::Sad
                    && params.planes() == 1
                    && params.prefiltered_max() < 128
                    && !params.confidence
            }
        };
        let small_kernel = match (params.method, plan.per_subgroup, params.block) {
            (Method::Bm, ..) => "block_match_small",
            (Method::Sgm, true, _) => "matching_cost_parallel",
            (Method::Sgm, false, 1) => "matching_cost_pixels",
            (Method::Sgm, false, _) => "matching_cost_small",
        };
        let small_block = small_method
            && largest.is_none_or(|largest| largest.small_block)
            && params.sums_small_blocks()
            && taken(small_kernel, MOST_SIDE)
            && left_stride.max(right_stride) <= limits.max_texture_dimension_2d;
        if !small_block {
            fits("a row of column sums", chunk_row, fewer)?;
        }
        // A block reaches `margin` rows beyond its own; the row before leaves its sum.
        let (planes, margin) = (u64::from(params.planes()), params.radius() + 1);
        let planes_row = 4 * planes * u64::from(left_stride.max(right_stride));
        let mut planes_rows = (allowed / planes_row).min(height.into()) as u32;
        if small_block && !plan.per_subgroup {
            planes_rows = planes_rows.min(limits.max_texture_dimension_2d / params.planes());
        }
        planes_rows = largest.map_or(planes_rows, |largest| planes_rows.min(largest.planes_rows));
        // Block matching may leave a piece's rows of the maps at once.
        let map_rows = if right_map <= allowed { height } else { (allowed / map_row - ROW_UNIT + 1) as u32 };
        let most_rows =
            if planes_rows == height { height } else { planes_rows.saturating_sub(2 * margin) }.min(map_rows);
        if most_rows == 0 {
            let needed = planes_row * u64::from(2 * margin + 1);
            return Err(Error::TooLarge { what: "what costs compare of a row".into(), needed, allowed, remedy: fewer });
        }
        let piece = |rows: Rows| {
            let first = rows.first.saturating_sub(margin);
            let planes = match planes_rows == height {
                true => whole,
                false => Rows { first, count: (rows.end() + margin).min(height) - first },
            };
            let chunks = if small_block { vec![] } else { cut(rows, most(chunk_bytes, chunk_row)) };
            Piece { rows, planes, chunks }
        };
        let pieces = bands.iter().map(|&band| cut(band, most_rows).into_iter().map(piece).collect()).collect();
        let (product, depth_offset) = params.depth.map_or((0, 0), |camera| camera.fixed());
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
                source_shift: source_texels.ilog2(),
            },
            binding: allowed,
            source_texels,
            source,
            gray: texels(4 * gray_stride),
            sums: 4 * pixels,
            left: 4 * planes * u64::from(left_stride) * u64::from(planes_rows),
            right: 4 * planes * u64::from(right_stride) * u64::from(planes_rows),
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
            planes_rows,
            pieces,
            part_bits,
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
