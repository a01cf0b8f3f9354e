//! The caller's resources that a frame is taken from and left in.

/// Where [`crate::StereoMatcher::record`] takes a pair from.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum Inputs<'a> {
    /// The pair that [`crate::StereoMatcher::upload`] wrote last.
    #[default]
    Uploaded,
    #[doc(hidden)]
    __(std::marker::PhantomData<&'a wgpu::TextureView>),
}

/// Where [`crate::StereoMatcher::record`] leaves the result, beside [`crate::StereoMatcher::output`].
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct Outputs<'a> {
    pub(crate) disparity: Option<&'a wgpu::TextureView>,
}
