"""The keywords of a matcher, for type checkers. python/tools/options.py writes this file."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

if TYPE_CHECKING:
    from gpu_stereo._native import Calibration, Camera

__all__ = ["Options"]

# What is not installed, for instance torch, offers masks, too.
_Mask = Any


class Options(TypedDict, total=False):
    """The keywords of :class:`gpu_stereo.StereoMatcher`; None leaves the default."""

    channels: Literal["rgb", "bgr"]
    bits: Union[int, Literal["auto"]]
    confidence: bool
    right_map: bool
    timings: bool
    cameras: Union[Camera, Calibration, None]
    mask: Union[_Mask, tuple[_Mask, _Mask], None]
    weights: Union[str, PathLike[str], None]
    # Smallest disparity to search, may be negative
    min_disp: Union[int, None]
    # How alike two pixels are; brings its usual prefilter and block along
    cost: Literal["sad", "ssd", "zsad", "bt", "bt-gray", "sad-xy", "census", "census-sobel", "ad-census", "learned", "learned-census", "ncc", "mi", None]
    # Neighbours that a census string compares
    census: Literal["5x5", "7x7", "9x7", "cs9x7", None]
    # ad-census: weight of an absolute difference in sixteenths, 0 to 64
    ad_weight: Union[int, None]
    # ad-census: weight of a differing bit in sixteenths, 0 to 64; learned-census: of census-sobel in 64ths
    census_weight: Union[int, None]
    # learned-census: weight of learned in 64ths, 0 to 64
    learned_weight: Union[int, None]
    # sad, bt: compare red, green and blue rather than luma
    color_cost: Union[bool, Literal["on", "off"], None]
    # Side of the square block, odd, 1 to 51
    block: Union[int, None]
    # The image on which costs are computed
    prefilter: Literal["xsobel", "sobel", "normalized", "none", None]
    # Clip of the prefilter and of derivatives, 1 to 127
    prefilter_cap: Union[int, None]
    # normalized: side of the window, odd, 3 to 51
    prefilter_window: Union[int, None]
    # How disparities are found; bm brings its own cost and block along, psmnet no filter but the preset's
    method: Literal["sgm", "bm", "bp", "psmnet", None]
    # sgm: directions along which costs are aggregated
    paths: Literal["3", "4", "5", "8", "16", 3, 4, 5, 8, 16, None]
    # sgm: penalty of a disparity step of 1, 0 to P2
    p1: Union[int, None]
    # sgm: penalty of a larger step, P1 to 127
    p2: Union[int, None]
    # sgm: lower P1 where the intensity changes along the path
    adaptive_p1: Union[bool, Literal["on", "off"], None]
    # sgm: lower P2 where the intensity changes along the path
    adaptive_p2: Union[bool, Literal["on", "off"], None]
    # sgm: step of the intensity up to which an adaptive P2 is whole, 1 to 255
    p2_step: Union[int, None]
    # sgm: how often costs are aggregated; the second time from the mean of the cost and of the first aggregate
    passes: Union[int, None]
    # bp, and the energy of all: how the smoothness grows with the difference of two neighbours
    smoothness: Literal["linear", "quadratic", "potts", None]
    # bp, and the energy of all: smoothness of a difference of 1, 0 to 127
    smoothness_weight: Union[int, None]
    # bp, and the energy of all: the largest smoothness of two neighbours, 0 to 127
    smoothness_truncation: Union[int, None]
    # bp, and the energy of all: intensity step from which on the smoothness is half, 1 to 255
    smoothness_edge: Union[int, Literal["off", False], None]
    # bp: levels, each of half the size, 1 to 10
    bp_levels: Union[int, None]
    # bp: how often messages are passed on each level, 1 to 1000
    bp_iterations: Union[int, None]
    # bp: share of a belief that is sent, in sixteenths, 4 to 16 (16: plain)
    bp_reweighting: Union[int, None]
    # psmnet: interpolate from corner pixel to corner pixel, as published weights want it
    align_corners: Union[bool, Literal["on", "off"], None]
    # Horizontal derivative that a block needs in sum
    texture: Union[int, Literal["off", False], None]
    # The winner must cost this many per cent less than all others but its neighbours, 0 (off) to 99
    uniqueness: Union[int, Literal["off", False], None]
    # How the winner is refined to 1/16 pixel
    subpixel: Literal["parabola", "equiangular", "off", False, None]
    # Largest difference in pixels between the left and the right view
    lr_check: Union[int, Literal["off", False], None]
    # Where the right view comes from
    right_view: Literal["diagonal", "match", None]
    # Regions of at most so many pixels are removed
    speckle_window: Union[int, Literal["off", False], None]
    # Largest disparity step between neighbours of a region, in pixels
    speckle_range: Union[int, None]
    # Median filter
    median: Literal["3", "5", "off", 3, 5, False, None]
    # How holes are filled
    fill: Literal["none", "background", "rays", "weighted-rays", "hirschmuller", None]
    # Median weighted by the left image, its radius in pixels, 1 to 15
    weighted_median: Union[int, Literal["off", False], None]
    # Intensity step at which a weight halves, 1 to 255; also of --fill weighted-rays
    weighted_median_sigma: Union[int, None]
    # Edge-preserving smoothing by weighted least squares
    wls: Union[bool, Literal["on", "off"], None]
    # Strength of that smoothing, 4 unless given; switches it on
    wls_lambda: Union[float, Literal["off", False], None]
    # Intensity step that stops it, 1.5 unless given; switches it on
    wls_sigma: Union[float, Literal["off", False], None]
    # Decide as OpenCV's StereoBM and StereoSGBM do; and no disparity where its range leaves the right image
    opencv_rules: Union[bool, Literal["on", "off"], None]
    # Compile the kernels with checks of every index and loop: slower, the same result
    shader_checks: Union[bool, Literal["on", "off"], None]
    # How the kernels are laid out; the same result
    schedule: Literal["auto", "per-thread", "per-subgroup", None]
    # On CPUs, refuse what the memory that is left does not hold, before any work
    memory_check: Union[bool, Literal["on", "off"], None]
