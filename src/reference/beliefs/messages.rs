use crate::reference::{Plane, Volume};
use crate::{Params, Smoothness};
use rayon::prelude::*;

/// What the pixels of a level receive from their neighbours.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Messages {
    /// By the neighbour from which it comes, in the order left, right, above, below: a byte for each pixel and disparity, 0
    /// from beyond the image.
    pub received: [Volume<u8>; 4],
}

/// The neighbours of a pixel: left, right, above and below, as columns and rows.
pub const WAYS: [(i64, i64); 4] = [(-1, 0), (1, 0), (0, -1), (0, 1)];

/// A message, and the pixel that it goes to, if there is one.
type Sent = Option<(usize, Vec<u8>)>;

/// The data terms of a level, and the gray image where the smoothness depends on it.
struct Level<'a, T> {
    data: &'a Volume<T>,
    gray: Option<&'a Plane<u8>>,
}

/// Stage `messages`: those of each level after all its iterations, from the coarsest level to the finest. `coarse` are the data
/// terms of all but the finest; without the `gray` left image the smoothness knows no edges.
pub fn messages(cost: &Volume<u8>, coarse: &[Volume<u16>], gray: Option<&Plane<u8>>, params: &Params) -> Vec<Messages> {
    let mut levels: Vec<Messages> = Vec::new();
    for data in coarse.iter().rev() {
        let start = Messages::started(levels.last(), data);
        levels.push(passed(&Level { data, gray: None }, start, &shares(params, false), params));
    }
    let start = Messages::started(levels.last(), cost);
    levels.push(passed(&Level { data: cost, gray }, start, &shares(params, true), params));
    levels
}

impl Messages {
    /// Those with which a level begins: each pixel has received what one of the coarser level has; without one, nothing.
    fn started<T>(coarser: Option<&Self>, data: &Volume<T>) -> Self {
        let Volume { width, height, disparities: n, .. } = *data;
        let mut started = Self { received: [(); 4].map(|()| Volume::new(width, height, n)) };
        for (fine, coarse) in started.received.iter_mut().zip(coarser.iter().flat_map(|coarser| &coarser.received)) {
            for (i, pixel) in fine.data.chunks_exact_mut(n).enumerate() {
                let (x, y) = (i % width / 2, i / width / 2);
                pixel.copy_from_slice(&coarse.data[(y * coarse.width + x) * n..][..n]);
            }
        }
        started
    }
}

/// The share f of the belief in what is sent, in sixteenths, for each iteration of a level. On the finest one it rises to the whole
/// after half of the iterations, within a quarter of them.
pub fn shares(params: &Params, finest: bool) -> Vec<u32> {
    let (all, share) = (params.bp_iterations, params.bp_reweighting);
    let (first, rising) = (all / 2, all / 4);
    let of = |i: u32| match i.checked_sub(first) {
        Some(since) if finest && since < rising => share + (16 - share) * (since + 1) / (rising + 1),
        Some(_) if finest => 16,
        _ => share,
    };
    (0..all).map(of).collect()
}

/// The messages after all iterations of a level. In each of them the pixels of one colour of a chessboard send to those of the
/// other; first those of which column and row add up to an even number.
fn passed<T: Copy + Into<u32> + Sync>(
    level: &Level<'_, T>,
    start: Messages,
    shares: &[u32],
    params: &Params,
) -> Messages {
    let Volume { width, height, disparities: n, .. } = *level.data;
    let mut messages = start;
    for (i, &share) in shares.iter().enumerate() {
        // Of each pixel that sends, and its neighbours.
        let sent = |p: usize| {
            let (x, y) = (p % width, p / width);
            if (x + y + i) % 2 > 0 {
                return Default::default();
            }
            let belief = belief(level.data, &messages, p);
            [0, 1, 2, 3].map(|way: usize| {
                let (u, v) = (x as i64 + WAYS[way].0, y as i64 + WAYS[way].1);
                let inside = (0..width as i64).contains(&u) && (0..height as i64).contains(&v);
                inside.then(|| {
                    let to = v as usize * width + u as usize;
                    let received = &messages.received[way].data[p * n..][..n];
                    (to, message(&belief, received, share, level.smoothness(p, to, params), params.smoothness))
                })
            })
        };
        let all: Vec<[Sent; 4]> = (0..width * height).into_par_iter().map(sent).collect();
        for (way, sent) in all.into_iter().flat_map(|sent| (0..).zip(sent)) {
            let Some((to, message)) = sent else { continue };
            // What goes to the left comes from the right.
            messages.received[way ^ 1].data[to * n..][..n].copy_from_slice(&message);
        }
    }
    messages
}

impl<T> Level<'_, T> {
    /// [`weight_and_truncation`] between two neighbours.
    fn smoothness(&self, p: usize, q: usize, params: &Params) -> [u32; 2] {
        weight_and_truncation(params, self.gray.map(|gray| [gray.data[p], gray.data[q]]))
    }
}

/// The weight and the truncation of the smoothness between two neighbours of these values in the gray image: half of them
/// across an edge of it.
pub(crate) fn weight_and_truncation(params: &Params, grays: Option<[u8; 2]>) -> [u32; 2] {
    let smoothness = [params.smoothness_weight, params.smoothness_truncation];
    match (grays, params.smoothness_edge) {
        (Some([p, q]), Some(edge)) if u32::from(p.abs_diff(q)) >= edge => smoothness.map(|value| value >> 1),
        _ => smoothness,
    }
}

/// The belief of a pixel: its data terms and all messages that it has received.
fn belief<T: Copy + Into<u32>>(data: &Volume<T>, messages: &Messages, p: usize) -> Vec<u32> {
    let n = data.disparities;
    let mut belief: Vec<u32> = data.data[p * n..][..n].iter().map(|&term| term.into()).collect();
    for received in &messages.received {
        belief.iter_mut().zip(&received.data[p * n..][..n]).for_each(|(sum, &part)| *sum += u32::from(part));
    }
    belief
}

/// What a pixel sends to a neighbour from which it has `received` a message: the least, over the disparities e of the sender, of h(e)
/// and the smoothness of d and e, less the least h.
fn message(belief: &[u32], received: &[u8], share: u32, [weight, truncation]: [u32; 2], kind: Smoothness) -> Vec<u8> {
    let h = |(&belief, &received): (&u32, &u8)| ((share * belief) >> 4) as i32 - i32::from(received);
    let h: Vec<i32> = belief.iter().zip(received).map(h).collect();
    let least = h.iter().copied().min().unwrap_or(0);
    // What exceeds the truncation by itself is no smaller than what every disparity may cost.
    let mut values: Vec<u32> = h.iter().map(|h| ((h - least) as u32).min(truncation)).collect();
    match kind {
        Smoothness::Potts => {}
        // Differences of more than one are steps of one.
        Smoothness::Linear => {
            for d in 1..values.len() {
                values[d] = values[d].min(values[d - 1] + weight);
            }
            for d in (1..values.len()).rev() {
                values[d - 1] = values[d - 1].min(values[d] + weight);
            }
        }
        Smoothness::Quadratic => {
            let before = values.clone();
            // Larger differences than that cost more than the truncation.
            let reach = truncation.checked_div(weight).map_or(before.len(), |most| most.isqrt() as usize);
            for (d, value) in values.iter_mut().enumerate() {
                let around = d.saturating_sub(reach)..(d + reach + 1).min(before.len());
                let sums = around.map(|e| before[e] + weight * (d.abs_diff(e) as u32).pow(2));
                *value = sums.min().unwrap_or(0);
            }
        }
    }
    values.into_iter().map(|value| value as u8).collect()
}

/// The beliefs at the full size, at most 89 + 4 * 127: what the winner is chosen from.
pub fn beliefs(cost: &Volume<u8>, messages: &Messages) -> Volume<u16> {
    let n = cost.disparities;
    let mut beliefs = Volume::new(cost.width, cost.height, n);
    beliefs.data.par_chunks_exact_mut(n).enumerate().for_each(|(p, pixel)| {
        pixel.iter_mut().zip(belief(cost, messages, p)).for_each(|(to, sum)| *to = sum as u16);
    });
    beliefs
}
