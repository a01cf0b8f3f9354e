//! matcher
use crate::*;
pub(crate) fn check_pair(left: &Image, right: &Image) -> Result<(), Error> {
    if (left.width(), left.height()) != (right.width(), right.height()) {
        return Err(Error::Image(format!(
            "the left image is {}x{} and the right {}x{}; both must have one size: crop or rectify them again",
            left.width(), left.height(), right.width(), right.height()
        )));
    }
    Ok(())
}
