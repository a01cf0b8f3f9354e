use crate::DisparityMap;
use rayon::prelude::*;

/// Pixels of a row that follow one another and belong to one region.
#[derive(Clone, Copy)]
struct Run {
    /// Its first column, and the one after its last.
    first: u32,
    end: u32,
    /// A run of the same region that is not behind it; itself for the first one of the region.
    parent: u32,
    /// Pixels of all runs whose parent this is.
    pixels: u64,
}

/// The runs of some rows.
#[derive(Default)]
struct Band {
    runs: Vec<Run>,
    /// For each row its first run, and the number of all.
    rows: Vec<usize>,
}

/// The first run of the region, with shorter ways to it.
fn root(runs: &mut [Run], mut at: usize) -> usize {
    while runs[at].parent as usize != at {
        let parent = runs[at].parent as usize;
        runs[at].parent = runs[parent].parent;
        at = parent;
    }
    at
}

/// Makes one region of two.
fn join(runs: &mut [Run], a: usize, b: usize) {
    let (a, b) = (root(runs, a), root(runs, b));
    if a != b {
        let (first, other) = (a.min(b), a.max(b));
        runs[other].parent = first as u32;
        runs[first].pixels += runs[other].pixels;
    }
}

/// Whether two neighbours belong to one region.
fn are_one(a: i16, b: i16, most: u32) -> bool {
    let invalid = DisparityMap::INVALID;
    a != invalid && b != invalid && u32::from(a.abs_diff(b)) <= most
}

impl Band {
    /// The runs of `data`, whole rows, with those of neighbouring rows joined.
    fn new(data: &[i16], width: usize, most: u32) -> Self {
        let mut band = Self { runs: Vec::new(), rows: vec![0] };
        for (y, row) in data.chunks_exact(width).enumerate() {
            band.append_row(row, most);
            if y > 0 {
                let above = band.rows[y - 1]..band.rows[y];
                let below = band.rows[y]..band.rows[y + 1];
                join_rows(&mut band.runs, [above, below], [&data[(y - 1) * width..y * width], row], most);
            }
        }
        band
    }

    fn append_row(&mut self, row: &[i16], most: u32) {
        let mut first = 0;
        for end in 1..=row.len() {
            if end < row.len() && are_one(row[end - 1], row[end], most) {
                continue;
            }
            if row[first] != DisparityMap::INVALID {
                let (parent, pixels) = (self.runs.len() as u32, (end - first) as u64);
                self.runs.push(Run { first: first as u32, end: end as u32, parent, pixels });
            }
            first = end;
        }
        self.rows.push(self.runs.len());
    }
}

/// Joins the runs of two neighbouring rows.
fn join_rows(runs: &mut [Run], [above, below]: [std::ops::Range<usize>; 2], [upper, lower]: [&[i16]; 2], most: u32) {
    let (mut a, mut b) = (above.start, below.start);
    while a < above.end && b < below.end {
        let (first, end) = (runs[a].first.max(runs[b].first) as usize, runs[a].end.min(runs[b].end) as usize);
        if first < end {
            let pairs = upper[first..end].iter().zip(&lower[first..end]);
            // Within runs no value is invalid.
            if pairs.into_iter().any(|(&u, &l)| u32::from(u.abs_diff(l)) <= most) {
                join(runs, a, b);
            }
        }
        if runs[a].end < runs[b].end { a += 1 } else { b += 1 }
    }
}

/// [`crate::reference::speckle`] by the runs of rows, which are joined to regions.
pub(super) fn speckle(map: &DisparityMap, window: u32, range: u32) -> DisparityMap {
    let (width, height) = (map.width as usize, map.height as usize);
    let most = 16 * range;
    let rows = height.div_ceil(rayon::current_num_threads()).max(8);
    let bands: Vec<Band> = map.data.par_chunks(rows * width).map(|data| Band::new(data, width, most)).collect();
    let mut all = Band { runs: Vec::with_capacity(bands.iter().map(|band| band.runs.len()).sum()), rows: vec![0] };
    for band in bands {
        let (before, y) = (all.runs.len(), all.rows.len() - 1);
        all.runs.extend(band.runs.iter().map(|run| Run { parent: run.parent + before as u32, ..*run }));
        all.rows.extend(band.rows[1..].iter().map(|end| end + before));
        if y > 0 {
            let above = all.rows[y - 1]..all.rows[y];
            let below = all.rows[y]..all.rows[y + 1];
            let row = |y: usize| &map.data[y * width..(y + 1) * width];
            join_rows(&mut all.runs, [above, below], [row(y - 1), row(y)], most);
        }
    }
    // No parent is behind its run.
    for at in 0..all.runs.len() {
        let parent = all.runs[at].parent as usize;
        if parent != at {
            (all.runs[at].parent, all.runs[at].pixels) = (all.runs[parent].parent, all.runs[parent].pixels);
        }
    }
    let mut filtered = map.clone();
    filtered.data.par_chunks_mut(width).zip(all.rows.par_windows(2)).with_min_len(16).for_each(|(row, at)| {
        for run in &all.runs[at[0]..at[1]] {
            if run.pixels <= u64::from(window) {
                row[run.first as usize..run.end as usize].fill(DisparityMap::INVALID);
            }
        }
    });
    filtered
}
