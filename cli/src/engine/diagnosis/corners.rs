//! Corners of an image (FAST), each with a binary descriptor of compared means (BRIEF).

/// An image in 8-bit gray, row by row.
pub struct Gray {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The samples.
    pub data: Vec<u8>,
}

/// A corner.
#[derive(Clone, Copy, Debug)]
pub struct Corner {
    /// Its column.
    pub x: i32,
    /// Its row.
    pub y: i32,
    /// The descriptor: which mean is the smaller one, for 256 pairs of places around the corner.
    bits: [u64; 4],
}

/// The most corners of an image.
const MOST: usize = 500;
/// The side of a tile that contributes at most one corner.
const TILE: usize = 6;
/// The image is divided into this many regions per side, each with its share of the corners and half as many again.
const REGIONS: usize = 6;
/// Contrasts that make a corner; a lower one is tried only if the higher one leaves too few corners.
const CONTRASTS: [i32; 4] = [32, 16, 8, 4];
/// The least distance of a corner from the border: all compared means lie inside.
const MARGIN: usize = REACH as usize + 3;
/// The greatest distance of a compared mean from the corner.
const REACH: i32 = 9;

/// The circle of the FAST detector.
const CIRCLE: [(isize, isize); 16] = [
    (0, -3),
    (1, -3),
    (2, -2),
    (3, -1),
    (3, 0),
    (3, 1),
    (2, 2),
    (1, 3),
    (0, 3),
    (-1, 3),
    (-2, 2),
    (-3, 1),
    (-3, 0),
    (-3, -1),
    (-2, -2),
    (-1, -3),
];

impl Gray {
    /// The means over squares of `factor` pixels.
    pub fn reduced(&self, factor: usize) -> Self {
        let (width, height) = (self.width / factor, self.height / factor);
        let mut data = Vec::with_capacity(width * height);
        for y in 0..height {
            let mut sums = vec![0_u32; width];
            for row in y * factor..(y + 1) * factor {
                let row = &self.data[row * self.width..][..width * factor];
                for (sum, samples) in sums.iter_mut().zip(row.chunks_exact(factor)) {
                    *sum += samples.iter().map(|&sample| u32::from(sample)).sum::<u32>();
                }
            }
            data.extend(sums.iter().map(|sum| (sum / (factor * factor) as u32) as u8));
        }
        Self { width, height, data }
    }
}

impl Corner {
    /// The Hamming distance of two descriptors, 0 to 256.
    pub fn distance(&self, other: &Self) -> u32 {
        self.bits.iter().zip(&other.bits).map(|(a, b)| (a ^ b).count_ones()).sum()
    }
}

/// The most distinct corners, spread over the image.
pub fn corners(image: &Gray) -> Vec<Corner> {
    let (width, height) = (image.width, image.height);
    if width <= 2 * MARGIN || height <= 2 * MARGIN {
        return Vec::new();
    }
    let mut found = Vec::new();
    for contrast in CONTRASTS {
        found = strongest(image, contrast);
        if found.len() >= MOST / 2 {
            break;
        }
    }
    found.sort_by_key(|&(score, place)| (std::cmp::Reverse(score), place));
    let mut regions = [0; REGIONS * REGIONS];
    found.retain(|&(_, place)| {
        let (x, y) = (place % width, place / width);
        let count = &mut regions[y * REGIONS / height * REGIONS + x * REGIONS / width];
        *count += 1;
        *count <= MOST * 3 / 2 / (REGIONS * REGIONS)
    });
    found.truncate(MOST);
    let sums = Sums::new(image);
    let pattern = pattern();
    found.iter().map(|&(_, place)| sums.corner((place % width) as i32, (place / width) as i32, &pattern)).collect()
}

/// The strongest corner of each tile that has one, with its strength and its place.
fn strongest(image: &Gray, contrast: i32) -> Vec<(u32, usize)> {
    let (width, height) = (image.width, image.height);
    let circle = CIRCLE.map(|(x, y)| y * width as isize + x);
    let tiles = width.div_ceil(TILE);
    let mut best = vec![(0, 0); tiles * height.div_ceil(TILE)];
    let mut candidates = vec![false; width - 2 * MARGIN];
    for y in MARGIN..height - MARGIN {
        mark(image, y, contrast as u8, &mut candidates);
        for x in (MARGIN..width - MARGIN).zip(&candidates).filter_map(|(x, &candidate)| candidate.then_some(x)) {
            let place = y * width + x;
            let centre = i32::from(image.data[place]);
            let (mut brighter, mut darker, mut score) = (0_u32, 0_u32, 0);
            for (i, &step) in circle.iter().enumerate() {
                let difference = i32::from(image.data[place.wrapping_add_signed(step)]) - centre;
                brighter |= u32::from(difference > contrast) << i;
                darker |= u32::from(difference < -contrast) << i;
                score += (difference.abs() - contrast).max(0) as u32;
            }
            let tile = &mut best[y / TILE * tiles + x / TILE];
            if score > tile.0 && (has_nine(brighter) || has_nine(darker)) {
                *tile = (score, place);
            }
        }
    }
    best.retain(|&(score, _)| score > 0);
    best
}

/// Marks the pixels of a row, without its margins, for which two of the four circle pixels on the axes are brighter, or two are
/// darker: no others can be corners.
fn mark(image: &Gray, y: usize, contrast: u8, candidates: &mut [bool]) {
    let row = |y: usize, x: usize| &image.data[y * image.width + x..][..image.width - 2 * MARGIN];
    let (above, below) = (row(y - 3, MARGIN), row(y + 3, MARGIN));
    let (before, after, centre) = (row(y, MARGIN - 3), row(y, MARGIN + 3), row(y, MARGIN));
    let sides = above.iter().zip(below).zip(before).zip(after);
    for ((candidate, &centre), (((&a, &b), &c), &d)) in candidates.iter_mut().zip(centre).zip(sides) {
        let (high, low) = (centre.saturating_add(contrast), centre.saturating_sub(contrast));
        let count = |is: [bool; 4]| is.into_iter().map(u8::from).sum::<u8>();
        let [brighter, darker] = [[a, b, c, d].map(|v| v > high), [a, b, c, d].map(|v| v < low)].map(count);
        *candidate = (brighter >= 2) | (darker >= 2);
    }
}

/// Whether nine consecutive bits of a circle of 16 are set.
fn has_nine(bits: u32) -> bool {
    let circle = bits | bits << 16;
    let two = circle & circle >> 1;
    let four = two & two >> 2;
    let eight = four & four >> 4;
    eight & circle >> 8 != 0
}

/// An integral image.
struct Sums {
    stride: usize,
    sums: Vec<u32>,
}

impl Sums {
    fn new(image: &Gray) -> Self {
        let stride = image.width + 1;
        let mut sums = vec![0_u32; stride * (image.height + 1)];
        for y in 0..image.height {
            let mut row = 0_u32;
            for x in 0..image.width {
                row = row.wrapping_add(image.data[y * image.width + x].into());
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1].wrapping_add(row);
            }
        }
        Self { stride, sums }
    }

    /// The sum of 5x5 pixels.
    fn around(&self, x: i32, y: i32) -> u32 {
        let at = |x: i32, y: i32| self.sums[y as usize * self.stride + x as usize];
        at(x + 3, y + 3).wrapping_sub(at(x - 2, y + 3)).wrapping_sub(at(x + 3, y - 2)).wrapping_add(at(x - 2, y - 2))
    }

    fn corner(&self, x: i32, y: i32, pattern: &[[i32; 4]]) -> Corner {
        let mut bits = [0; 4];
        for (i, &[ax, ay, bx, by]) in pattern.iter().enumerate() {
            bits[i / 64] |= u64::from(self.around(x + ax, y + ay) < self.around(x + bx, y + by)) << (i % 64);
        }
        Corner { x, y, bits }
    }
}

/// Which means are compared: 256 pairs of places around a corner, the same ones always.
fn pattern() -> Vec<[i32; 4]> {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut place = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        // The sum of two uniform numbers is mostly near the middle.
        let throw = |shift: u32| ((state >> shift) % (REACH as u64 + 1)) as i32;
        throw(8) + throw(30) - REACH
    };
    (0..256).map(|_| [(); 4].map(|()| place())).collect()
}
