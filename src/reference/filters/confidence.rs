use crate::{ConfidenceMap, DisparityMap};

/// How far the best rival of a winner that costs `best` is behind it, as a share of its own cost: floor(255 (rival - best)
/// / rival), 0 to 255. The rival is the cheapest disparity that is no neighbour of the winner. Without one it is 255; where
/// it costs nothing, 0.
///
/// It is 255 (1 - PKR^-1) with the peak ratio of Hu and Mordohai, "A Quantitative Evaluation of Confidence Measures for
/// Stereo Vision", IEEE TPAMI 34(11), 2012 (PKRN, but that neighbours are no rivals).
pub fn margin(best: u32, rival: Option<u32>) -> u8 {
    match rival {
        None => 255,
        Some(0) => 0,
        Some(rival) => (255 * (rival - best) / rival) as u8,
    }
}

/// Stage `confidence`: the [`margin`] of each pixel's winner, at least 1; 0 where the final map has no disparity.
///
/// A pixel whose value a filter changed keeps the margin of its own winner.
pub fn confidence(map: &DisparityMap, margins: &ConfidenceMap) -> ConfidenceMap {
    let of = |(&value, &margin): (&i16, &u8)| if value == DisparityMap::INVALID { 0 } else { margin.max(1) };
    ConfidenceMap { data: map.data.iter().zip(&margins.data).map(of).collect(), ..*margins }
}
