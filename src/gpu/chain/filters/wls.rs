//! Weighted least squares.

use crate::gpu::chain::filters::map_step::by_rows;
use crate::gpu::layout::{Dispatch, Frame, Rows};
use crate::gpu::recording::Bound::{self, Buffer, Texture};
use crate::gpu::recording::{Builder, Written};
use crate::params::Filter;

/// Stage `wls` of the map that the last step left.
pub(super) fn wls(b: &mut Builder<'_>, gray: &wgpu::TextureView, couplings: Vec<u32>) -> wgpu::Buffer {
    let Frame { width, height, map_stride, volume_stride, .. } = b.sizes.frame;
    let texels = b.copy_to_texels();
    let couplings = b.table("wls.couplings", couplings);
    let pixels = u64::from(volume_stride) * u64::from(height);
    let (values, shares) = (b.buffer("wls.values", 8 * pixels), b.buffer("wls.shares", 4 * pixels));
    let carry = b.buffer("wls.carry", 16 * u64::from(width.max(height)));
    let row = u64::from(volume_stride);
    let (values_rows, shares_rows) = (Bound::Rows(&values, 8 * row), Bound::Rows(&shares, 4 * row));
    let storage = [Texture(&texels), values_rows];
    b.step_rows("wls_start", &storage, Dispatch::default(), map_stride / 4, 1, Written::Part);
    let lots = b.lots(&[values_rows, shares_rows]);
    for iteration in 0..3 {
        let shift = 256 * iteration;
        for &rows in &lots {
            let (lines, stride) = (rows.count, volume_stride as i32);
            let dispatch =
                Dispatch { first_row: rows.first, rows: width, lines, dx: 1, dy: stride, shift, ..Dispatch::default() };
            let own = [b.lot(values_rows, rows), b.lot(shares_rows, rows), Buffer(&carry)];
            let storage = [&own[..], &[Texture(gray), Buffer(&couplings)]].concat();
            b.step("wls_forward", &storage, dispatch, lines, 1, Written::Part);
            b.step("wls_backward", &own, dispatch, lines, 1, Written::Part);
        }
        let down = |rows: Rows| Dispatch {
            first_row: rows.first,
            rows: rows.count,
            lines: width,
            dx: volume_stride as i32,
            dy: 1,
            row_step: 1,
            shift,
            ..Dispatch::default()
        };
        for &rows in &lots {
            let dispatch = Dispatch { carried: (rows.first > 0).into(), ..down(rows) };
            let own = [b.lot(values_rows, rows), b.lot(shares_rows, rows), Buffer(&carry)];
            let storage = [&own[..], &[Texture(gray), Buffer(&couplings)]].concat();
            b.step("wls_forward", &storage, dispatch, width, 1, Written::Part);
        }
        for &rows in lots.iter().rev() {
            let dispatch = Dispatch { carried: (rows.end() < height).into(), ..down(rows) };
            let own = [b.lot(values_rows, rows), b.lot(shares_rows, rows), Buffer(&carry)];
            b.step("wls_backward", &own, dispatch, width, 1, Written::Part);
        }
    }
    let smooth = b.buffer("wls", b.sizes.map);
    let storage = [values_rows, by_rows(b, &smooth)];
    b.step_rows("wls", &storage, Dispatch::default(), map_stride, 1, Written::Filter(Filter::Wls));
    smooth
}
