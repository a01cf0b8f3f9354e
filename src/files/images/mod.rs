//! Images: two files, or one that holds both views, become the pair that the matcher takes.

mod bits;
mod decoder;
mod kinds;
mod one_file;
mod pair;
mod split;

pub use bits::Bits;
pub use decoder::has_image_ending;
pub(super) use decoder::{MAX_PIXELS, decode, decoder};
pub use kinds::is_video;
pub use one_file::{Stated, stated};
pub use pair::{ImagePair, read_both, read_pair, split_frame};
pub use split::{Arrangement, Split};
