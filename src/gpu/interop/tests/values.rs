//! Every value of a map in every format of a texture.

use super::*;

/// The numbers of 16-bit floats that are not negative, in their order: of bits 0, 1 and so on.
fn halves() -> Vec<f64> {
    let value = |bits: u32| match (bits >> 10, f64::from(bits & 1023)) {
        (0, fraction) => fraction * 2f64.powi(-24),
        (exponent, fraction) => (1024.0 + fraction) * 2f64.powi(exponent as i32 - 25),
    };
    (0..0x7c00).map(value).collect()
}

/// The bits of the nearest of `halves`, of two the even one.
fn half_bits(halves: &[f64], value: f64) -> u16 {
    let sign = if value < 0.0 { 0x8000 } else { 0 };
    let above = halves.partition_point(|half| *half < value.abs());
    let below = above.saturating_sub(1);
    let [far, near] = [halves[above] - value.abs(), value.abs() - halves[below]];
    let nearest = match far.total_cmp(&near) {
        std::cmp::Ordering::Less => above,
        std::cmp::Ordering::Greater => below,
        std::cmp::Ordering::Equal => above - above % 2, // the even one: those two are `above` and the one before
    };
    sign | nearest as u16
}

/// Bits of the nearest float to `value` / 10^6, in whole numbers; of two the even one.
fn metre_bits(value: u32) -> u32 {
    if value == 0 {
        return 0;
    }
    // value / 10^6 = quotient / 2^shift with 24 binary digits.
    let (mut shift, million) = (0, 1_000_000u128);
    while (u128::from(value) << shift) / million < 1 << 23 {
        shift += 1;
    }
    let (quotient, rest) = ((u128::from(value) << shift) / million, (u128::from(value) << shift) % million);
    let up = match (2 * rest).cmp(&million) {
        std::cmp::Ordering::Less => 0,
        std::cmp::Ordering::Greater => 1,
        std::cmp::Ordering::Equal => quotient % 2,
    };
    ((127 + 23 - shift) << 23) as u32 + (quotient + up) as u32 - (1 << 23)
}

/// Depths of all sizes: the smallest ones, those around powers of two and of ten and around quotients of few digits, the
/// largest ones, and others.
pub(super) fn depths(count: usize) -> Vec<u32> {
    let mut depths: Vec<u32> = (0..3000).collect();
    for at in (0..32).map(|bit| 1u32 << bit).chain((0..10).map(|power| 10u32.pow(power))) {
        depths.extend((0..9).map(|i| at.wrapping_add(i).wrapping_sub(4)));
    }
    // 15625 / 10^6 is 1 / 64: quotients that end, among them those in the middle between two numbers of 11 digits.
    depths.extend((0..1 << 17).map(|i| 15_625 * (2 * i + 1)));
    let more = count - depths.len();
    depths.extend((0..more as u32).map(|i| i.wrapping_mul(0x9e37_79b9) ^ (i >> 7)));
    depths
}

#[test]
fn floats_of_a_depth_are_the_nearest() {
    let depths = depths(1 << 20);
    let map = crate::DepthMap { width: 1 << 10, height: 1 << 10, data: depths };
    for (metres, value) in map.metres().iter().zip(&map.data) {
        assert_eq!(metres.to_bits(), metre_bits(*value), "{value} micrometres");
    }
}

/// All disparities and very many depths, in each format that takes them, drawn and stored.
#[test]
fn every_value_leaves_as_it_is() {
    let Some((adapter, device, queue)) = device() else { return };
    let (width, height) = (512, 512);
    let stand = Stand::new(&device, &queue, width, height, PixelFormat::Gray8);
    let disparities: Vec<i16> = (0..width * height).map(|i| (i / 3) as i16).collect();
    let depths = depths((width * height) as usize);
    queue.write_buffer(&stand.output, 0, bytemuck::cast_slice(&disparities));
    queue.write_buffer(&stand.depth, 0, bytemuck::cast_slice(&depths));
    let halves = halves();
    let half = |value: f64| half_bits(&halves, value).to_le_bytes();
    let least = |metres: f64| if metres == 0.0 { 0.0 } else { metres.max(2f64.powi(-14)) };
    let pixels = disparities.iter().map(|&v| f64::from(v) / 16.0);
    let metres = depths.iter().map(|&v| f64::from(v) / 1e6);
    let expected: [(bool, TextureFormat, Vec<u8>); 6] = [
        (false, TextureFormat::R32Float, pixels.clone().flat_map(|v| (v as f32).to_le_bytes()).collect()),
        (false, TextureFormat::R16Sint, disparities.iter().flat_map(|v| v.to_le_bytes()).collect()),
        (false, TextureFormat::R16Float, pixels.flat_map(half).collect()),
        (true, TextureFormat::R32Float, depths.iter().flat_map(|v| metre_bits(*v).to_le_bytes()).collect()),
        (true, TextureFormat::R32Uint, bytemuck::cast_slice(&depths).to_vec()),
        (true, TextureFormat::R16Float, metres.flat_map(|v| half(least(v))).collect()),
    ];
    for (depth, format, expected) in expected {
        for usage in [wgpu::TextureUsages::RENDER_ATTACHMENT, wgpu::TextureUsages::STORAGE_BINDING] {
            let stored = usage == wgpu::TextureUsages::STORAGE_BINDING;
            if stored && !matches!(format, TextureFormat::R32Float | TextureFormat::R32Uint) {
                continue;
            }
            let target = texture(&device, [width, height], format, usage | wgpu::TextureUsages::COPY_SRC);
            let outputs = Outputs::default();
            let outputs = if depth { outputs.depth(&target) } else { outputs.disparity(&target) };
            stand.leave(&outputs);
            let got = stand.read(&target);
            let bytes = format.block_copy_size(None).unwrap() as usize;
            let first = got.chunks_exact(bytes).zip(expected.chunks_exact(bytes)).position(|(a, b)| a != b);
            let value = first.map(|i| if depth { i64::from(depths[i]) } else { disparities[i].into() });
            let name = adapter.get_info().name;
            assert!(
                got.len() == expected.len() && first.is_none(),
                "{value:?} in {format:?}, stored {stored}, on {name}"
            );
        }
    }
}
