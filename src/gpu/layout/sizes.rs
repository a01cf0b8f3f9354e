//! The sizes and strides of every buffer, computed before anything is created.

use crate::gpu::layout::bands::{Division, Former, Piece};
use crate::gpu::layout::features::FeatureSizes;
use crate::gpu::layout::layers::Layers;
use crate::gpu::layout::request::{Request, SMALLER, Strides, source_layout};
use crate::gpu::layout::rows::Rows;
use crate::gpu::layout::scales::{Scale, scales};
use crate::gpu::layout::uniforms::{Frame, TEXTURE_ROW};
use crate::gpu::plan::{MOST_PARTS, Plan, penalty_bytes};
use crate::{Error, Fill, Method, Params, PixelFormat, reference};

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
    /// Bytes of the right view's map, followed by the margins if a confidence is wanted, and by the labels if those are.
    pub(crate) right_map: u64,
    /// Bytes of the confidence.
    pub(crate) confidence: u64,
    /// Bytes of one number of 32 bits a pixel of a map.
    pub(crate) regions: u64,
    /// Bytes of the nearest values on both sides of each pixel, and of what comes along with them.
    pub(crate) nearest: u64,
    /// Bytes of a row of a volume with a byte a disparity.
    pub(crate) volume_row: u64,
    /// Bytes of a row of column sums.
    pub(crate) columns_row: u64,
    /// Bytes of a row of the statistics of blocks.
    pub(crate) statistics_row: u64,
    pub(crate) bands: Vec<Rows>,
    /// The levels of belief propagation, the finest first.
    pub(crate) scales: Vec<Scale>,
    /// Where the values of the network lie, if there is one.
    pub(crate) layers: Option<Layers>,
    /// The same of a network of features.
    pub(crate) features: Option<FeatureSizes>,
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

/// Bytes of what holds a number or a few for each pixel.
struct PixelSizes {
    map: u64,
    right_map: u64,
    regions: u64,
    nearest: u64,
    part_bits: Option<u32>,
}

impl Sizes {
    /// Bytes of the buffer of a volume of `rows` rows: whole rows of the texture.
    pub(crate) fn volume(&self, rows: u32) -> u64 {
        (u64::from(rows) * self.volume_row).next_multiple_of(TEXTURE_ROW)
    }

    /// The sizes for images of `width` x `height` pixels. `largest` are those for larger ones, whose buffers are used for these.
    pub(crate) fn new(
        width: u32,
        height: u32,
        format: PixelFormat,
        params: &Params,
        limits: &wgpu::Limits,
        plan: &Plan,
        largest: Option<&Self>,
    ) -> Result<Self, Error> {
        let request = Request { width, height, format, params, limits, plan };
        request.check_sides()?;
        let strides = Strides::new(width, params);
        let (source_texels, source) = match largest {
            Some(largest) => {
                let texels = largest.source_texels;
                (texels, request.source_bytes().next_multiple_of(16 * u64::from(texels)))
            }
            None => source_layout([width, height], format, limits),
        };
        check_images(&request, &strides, source_texels, source)?;
        let penalties = penalties(&request)?;
        let PixelSizes { map, right_map, regions, nearest, part_bits } = PixelSizes::new(&request, &strides, source)?;
        let former = largest.map(|largest| Former {
            band_bytes: u64::from(largest.bands.first().map_or(1, |band| band.count)) * largest.volume_row,
            small_block: largest.small_block,
            planes_rows: largest.planes_rows,
        });
        let division = Division::new(&request, &strides, right_map, former)?;
        let plane_rows = u64::from(params.compared_planes().max(1)) * u64::from(division.planes_rows);
        Ok(Self {
            frame: frame(&request, &strides, map, source_texels),
            binding: request.binding(),
            source_texels,
            source,
            gray: whole_rows(&request, 16 * u64::from(strides.gray)),
            sums: 4 * request.pixels(),
            left: 4 * u64::from(strides.left) * plane_rows,
            right: 4 * u64::from(strides.right) * plane_rows,
            map,
            right_map,
            confidence: map / 2,
            regions,
            nearest,
            penalties,
            volume_row: division.volume_row,
            columns_row: division.columns_row,
            statistics_row: division.statistics_row,
            layers: layers(&request)?,
            features: params
                .feature_network()
                .map(|network| FeatureSizes::new(&request, &network, division.planes_rows)),
            scales: scales(params, width, height, strides.volume, &division.bands),
            bands: division.bands,
            columns_room: division.columns_room,
            small_block: division.small_block,
            planes_rows: division.planes_rows,
            pieces: division.pieces,
            part_bits,
        })
    }
}

fn layers(request: &Request<'_>) -> Result<Option<Layers>, Error> {
    let network = request.params.network.as_ref().filter(|_| request.params.method == Method::Psmnet);
    network.map(|network| Layers::new(request, network)).transpose()
}

/// Bytes of an image with `row` bytes a row that is copied into a texture: whole rows of that.
fn whole_rows(request: &Request<'_>, row: u64) -> u64 {
    (row * u64::from(request.height)).next_multiple_of(TEXTURE_ROW)
}

/// The images and what is made of them before the cost.
fn check_images(request: &Request<'_>, strides: &Strides, source_texels: u32, source: u64) -> Result<(), Error> {
    let Request { format, params, limits, .. } = *request;
    if params.has_table() {
        request.fits("the histogram of all pairs of values", 4 * 256 * 256, "take another cost")?;
    }
    if params.sums_windows() {
        request.fits("the sums over windows", 4 * request.pixels(), SMALLER)?;
    }
    let texture_rows = u64::from(limits.max_texture_dimension_2d);
    let copied = (limits.max_buffer_size / TEXTURE_ROW).min(texture_rows) * TEXTURE_ROW;
    let gray_row = 16 * u64::from(strides.gray) * if format.is_deep() { 2 } else { 1 };
    let map_row = 4 * u64::from(strides.map);
    for (what, needed, allowed) in [
        ("an image", source, 16 * u64::from(source_texels) * texture_rows), // a texture alone
        ("a gray image", whole_rows(request, gray_row), copied),
        ("a disparity map", whole_rows(request, map_row), copied),
    ] {
        if needed > allowed {
            return Err(Error::TooLarge { what: what.into(), needed, allowed, remedy: SMALLER });
        }
    }
    request.rows_fit("rows of a gray image", gray_row, SMALLER)?;
    request.rows_fit("rows of a disparity map", map_row, SMALLER)
}

/// Bytes of the penalties of a direction. The vector after the last one is read, too.
fn penalties(request: &Request<'_>) -> Result<u64, Error> {
    let Request { width, height, plan, params, .. } = *request;
    let (across, along) = (width * 2 * (height.div_ceil(2) / 16 + 1), (width / 16 + 1) * height);
    let penalties = u64::from(penalty_bytes(params)) * 16 * u64::from(across.max(along));
    if plan.adaptive {
        request.fits(
            "the penalties of the pixels",
            penalties,
            "make the images smaller or switch adaptive-p1 and adaptive-p2 off",
        )?;
    }
    Ok(penalties)
}

impl PixelSizes {
    /// `source`: bytes of an uploaded image.
    fn new(request: &Request<'_>, strides: &Strides, source: u64) -> Result<Self, Error> {
        let Request { height, params, limits, .. } = *request;
        let (map_row, allowed) = (4 * u64::from(strides.map), request.binding());
        let map = whole_rows(request, map_row);
        if params.has_table() {
            let what = "a disparity map for the histogram of mutual information";
            request.fits(what, map, "make the images smaller or take another cost")?;
        }
        let right_map = map * (1 + u64::from(params.confidence) + u64::from(params.has_labels()));
        if right_map > map {
            let what = "a disparity map with its confidence or its labels";
            request.fits(what, right_map, "make the images smaller or switch those off")?;
        }
        if params.wls.is_some() {
            request.rows_fit("rows of two numbers a pixel", 8 * u64::from(strides.volume), SMALLER)?;
        }
        let regions = 2 * map;
        if params.rectify.is_some() {
            request.fits("a rectified image", source, SMALLER)?;
            request.fits("the positions of rectified pixels", 8 * request.pixels(), SMALLER)?;
        }
        if params.depth.is_some() {
            request.rows_fit("rows of a depth map", 2 * map_row, SMALLER)?;
        }
        let part_bits = (regions > allowed).then(|| (allowed / 4).ilog2());
        let parts = part_bits.map_or(1, |bits| regions.div_ceil(4 << bits));
        if params.speckle_window > 0 {
            request.rows_fit("rows of the regions of the speckle filter", 2 * map_row, SMALLER)?;
        }
        if params.speckle_window > 0 && (parts > MOST_PARTS.into() || regions > limits.max_buffer_size) {
            return Err(Error::TooLarge {
                what: "the regions of the speckle filter".into(),
                needed: regions,
                allowed: limits.max_buffer_size.min(u64::from(MOST_PARTS) * (4 << part_bits.unwrap_or(0))),
                remedy: "make the images smaller or switch the filter off",
            });
        }
        // Twice so many where the gray of their pixels comes along.
        let widened = if params.fill == Fill::WeightedRays { 2 } else { 1 };
        let nearest_row = widened * 32 * u64::from(strides.map / 4 + 1);
        let nearest = nearest_row * u64::from(height);
        if params.fill != Fill::None {
            let remedy = "make the images smaller or switch fill off";
            request.rows_fit("rows of the values that fill holes", nearest_row, remedy)?;
            request.fits("the occlusions", map_row / 4 * u64::from(height), remedy)?;
        }
        Ok(Self { map, right_map, regions, nearest, part_bits })
    }
}

/// The uniform block of a frame.
fn frame(request: &Request<'_>, strides: &Strides, map: u64, source_texels: u32) -> Frame {
    let Request { width, height, params, .. } = *request;
    let (product, depth_offset) = params.depth.map_or((0, 0), |camera| camera.fixed());
    Frame {
        width,
        height,
        min_disparity: params.min_disparity,
        block_radius: params.radius(),
        prefilter_cap: params.prefilter_cap,
        cost_scale: reference::matching_cost_scale(params),
        p1: params.p1,
        p2: params.p2,
        lr_max_difference: params.lr_check.unwrap_or(0),
        gray_stride: strides.gray,
        left_stride: strides.left,
        right_stride: strides.right,
        map_stride: strides.map,
        volume_stride: strides.volume,
        map_words: (map / 4) as u32,
        texture: params.texture,
        speckle_window: params.speckle_window,
        speckle_range: 16 * params.speckle_range as i32,
        fill_max_difference: params.lr_check.unwrap_or(1) as i32,
        depth_high: (product >> 32) as u32,
        depth_low: product as u32,
        depth_offset,
        source_shift: source_texels.ilog2(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
