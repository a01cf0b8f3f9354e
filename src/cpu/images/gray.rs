//! Stage `gray`.

use rayon::prelude::*;

use crate::cpu::images::padded::{Padded, Samples};
use crate::cpu::instructions::Instructions;
use crate::reference::{self, Channel, Plane};
use crate::{Image, Pixels};

/// A channel of an image at the depth of its samples.
pub fn samples(image: &Image, channel: Channel, instructions: Instructions) -> Samples {
    let (width, height) = (image.width() as usize, image.height() as usize);
    match image.pixels() {
        Pixels::Gray8(samples) => {
            let row = |y: usize, row: &mut [u8]| row.copy_from_slice(&samples[y * width..][..width]);
            Samples::Bytes(Padded::from_rows(width, height, row))
        }
        Pixels::Gray16(samples) => {
            let row = |y: usize, row: &mut [u16]| row.copy_from_slice(&samples[y * width..][..width]);
            Samples::Words(Padded::from_rows(width, height, row))
        }
        Pixels::Rgba8(samples) => Samples::Bytes(Padded::from_rows(width, height, |y, row| {
            let colours = &samples[y * width * 4..][..width * 4];
            instructions.run(
                #[inline(always)]
                || read(colours, channel, row),
            );
        })),
        Pixels::Rgba16(samples) => Samples::Words(Padded::from_rows(width, height, |y, row| {
            let colours = &samples[y * width * 4..][..width * 4];
            instructions.run(
                #[inline(always)]
                || read(colours, channel, row),
            );
        })),
    }
}

/// Luma in 8 bits, the twin of [`gray`](crate::reference::gray).
pub fn luma(image: &Image, instructions: Instructions) -> Plane<u8> {
    let (width, height) = (image.width() as usize, image.height() as usize);
    let data = match image.pixels() {
        Pixels::Gray8(samples) => samples.clone(),
        Pixels::Rgba8(samples) => {
            let mut data = vec![0; width * height];
            let rows = data.par_chunks_exact_mut(width).zip(samples.par_chunks_exact(4 * width)).with_min_len(16);
            rows.for_each(|(row, colours)| {
                instructions.run(
                    #[inline(always)]
                    || read(colours, Channel::Luma, row),
                );
            });
            data
        }
        Pixels::Gray16(_) | Pixels::Rgba16(_) => return reference::gray(image, Channel::Luma),
    };
    Plane { width, height, data }
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

/// A row of a colour image as this channel.
#[inline(always)]
fn read<T: Sample>(colours: &[T], channel: Channel, row: &mut [T]) {
    let colours = colours.as_chunks::<4>().0;
    match channel {
        Channel::Luma => {
            for (value, &[red, green, blue, _]) in row.iter_mut().zip(colours) {
                let [red, green, blue]: [u32; 3] = [red.into(), green.into(), blue.into()];
                *value = T::of((9798 * red + 19235 * green + 3735 * blue + 16384) >> 15);
            }
        }
        Channel::Sample(sample) => {
            for (value, colour) in row.iter_mut().zip(colours) {
                *value = colour[sample];
            }
        }
    }
}
