//! Stage `gray`.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::cpu::images::padded::{Padded, Samples};
use crate::cpu::instructions::Instructions;
use crate::reference::{self, Channel, Plane};
use crate::{ImageView, ViewFormat};

/// A channel of an image at the depth of its samples.
pub fn samples(image: ImageView<'_>, channel: Channel, instructions: Instructions) -> Samples {
    let (width, height) = (image.width() as usize, image.height() as usize);
    match image.format().is_deep() {
        false => Samples::Bytes(Padded::from_rows(width, height, |y, row| {
            read_row(image, y, channel, row, instructions);
        })),
        true => Samples::Words(Padded::from_rows(width, height, |y, row| {
            read_deep_row(image, y, channel, row, instructions);
        })),
    }
}

/// Luma in 8 bits, the twin of [`gray`](crate::reference::gray).
pub fn luma(image: ImageView<'_>, instructions: Instructions) -> Plane<u8> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    if image.format().is_deep() {
        return reference::gray(image, Channel::Luma);
    }
    let mut data = vec![0; width * height];
    let rows = data.par_chunks_exact_mut(width).enumerate().with_min_len(16);
    rows.for_each(|(y, row)| read_row(image, y, Channel::Luma, row, instructions));
    Plane { width, height, data }
}

/// A row of an image of 8 bits as this channel.
fn read_row(image: ImageView<'_>, y: usize, channel: Channel, row: &mut [u8], instructions: Instructions) {
    let samples = image.row(y as u32);
    instructions.run(
        #[inline(always)]
        || match image.view_format() {
            ViewFormat::Rgba8 => read::<u8, 4, 0, 2>(samples, channel, row),
            ViewFormat::Bgra8 => read::<u8, 4, 2, 0>(samples, channel, row),
            ViewFormat::Rgb8 => read::<u8, 3, 0, 2>(samples, channel, row),
            ViewFormat::Bgr8 => read::<u8, 3, 2, 0>(samples, channel, row),
            ViewFormat::Gray8 | ViewFormat::Gray16 | ViewFormat::Rgba16 => row.copy_from_slice(samples),
        },
    );
}

/// The same of an image of 16 bits.
fn read_deep_row(image: ImageView<'_>, y: usize, channel: Channel, row: &mut [u16], instructions: Instructions) {
    let bytes = image.row(y as u32);
    if image.view_format() == ViewFormat::Gray16 {
        bytemuck::cast_slice_mut(row).copy_from_slice(bytes);
        return;
    }
    // The caller's memory need not be aligned.
    let samples = match bytemuck::try_cast_slice(bytes) {
        Ok(samples) => Cow::Borrowed(samples),
        Err(_) => Cow::Owned(bytemuck::pod_collect_to_vec(bytes)),
    };
    instructions.run(
        #[inline(always)]
        || read::<u16, 4, 0, 2>(&samples, channel, row),
    );
}

/// A number that samples are of.
trait Sample: Copy + Into<u32> {
    fn of(value: u32) -> Self;
}

impl Sample for u8 {
    #[inline(always)]
    fn of(value: u32) -> Self {
        value as Self
    }
}

impl Sample for u16 {
    #[inline(always)]
    fn of(value: u32) -> Self {
        value as Self
    }
}

/// A row of a colour image as this channel: pixels of `SAMPLES`, of which the one at `RED` is red, the second green, the one at
/// `BLUE` blue.
#[inline(always)]
fn read<T: Sample, const SAMPLES: usize, const RED: usize, const BLUE: usize>(
    samples: &[T],
    channel: Channel,
    row: &mut [T],
) {
    let colours = samples.as_chunks::<SAMPLES>().0;
    match channel {
        Channel::Luma => {
            for (value, colour) in row.iter_mut().zip(colours) {
                let [red, green, blue]: [u32; 3] = [colour[RED].into(), colour[1].into(), colour[BLUE].into()];
                *value = T::of((9798 * red + 19235 * green + 3735 * blue + 16384) >> 15);
            }
        }
        Channel::Sample(sample) => {
            let sample = [RED, 1, BLUE][sample];
            for (value, colour) in row.iter_mut().zip(colours) {
                *value = colour[sample];
            }
        }
    }
}
