"""The filter of disparities of OpenCV's contributed module ``ximgproc``.

What is not here is OpenCV's own, where opencv-contrib-python is installed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _native
from ._arrays import Image, Map, Rect, error, image, integer, into, map16, number, rectangle
from ._matchers import StereoBM, StereoBM_create, StereoMatcher, StereoSGBM, StereoSGBM_create

# ruff: noqa: N802, N803, N806 - OpenCV's names

__all__ = [
    "DisparityWLSFilter",
    "computeBadPixelPercent",
    "computeMSE",
    "createDisparityWLSFilter",
    "createDisparityWLSFilterGeneric",
    "createRightMatcher",
    "getDisparityVis",
]

_NOWHERE: Rect = (0, 0, 0, 0)
_UNCHECKED = 1_000_000
_UNKNOWN = 16320
# What ximgproc writes outside of the part that it filters.
_OUTSIDE = -16
_ROLL_OFF = np.float32(0.001)
_SMALLEST = np.float32(1e-43)


class DisparityWLSFilter:
    """Smooths a map along the edges of the image, by weighted least squares, after a check of the left map by the right one."""

    def __init__(self, use_confidence: bool, margins: Rect = _NOWHERE) -> None:
        self._use_confidence = use_confidence
        self._margins = margins
        self._lambda = 8000.0
        self._sigma = 1.0
        self._threshold = 24
        self._radius = 5
        self._roi = _NOWHERE
        self._confidence: npt.NDArray[np.float32] | None = None

    def filter(
        self,
        disparity_map_left: Map,
        left_view: Image,
        filtered_disparity_map: Map | None = None,
        disparity_map_right: Map | None = None,
        ROI: Rect = _NOWHERE,
        right_view: Image | None = None,
    ) -> Map:
        """The filtered map, int16 in 1/16 px, of the size of ``left_view``; -16 outside of the part that is filtered.

        The maps are int16, in 1/16 px, as a matcher and ``createRightMatcher`` give them; ``left_view`` is uint8, height x width
        or height x width x 3, and may be larger than they are. ``right_view`` is not read, as in OpenCV.
        """
        left = map16("disparity_map_left", disparity_map_left)
        view = image("left_view", left_view, (1, 3))
        height, width = left.shape
        size = (view.shape[1], view.shape[0])
        ratio = np.float32(1.0) if size == (width, height) else np.float32(width) / np.float32(size[0])
        self._roi = self._part(rectangle("ROI", ROI), width, height)
        weights = None
        if self._use_confidence:
            if disparity_map_right is None:
                raise error("disparity_map_right is missing; createDisparityWLSFilterGeneric(False) does without it")
            right = map16("disparity_map_right", disparity_map_right)
            if right.shape != left.shape:
                raise error(f"disparity_map_right has the shape {right.shape}, disparity_map_left {left.shape}")
            weights = _native.agreement_confidence(
                left, right, self._roi, int(ratio * np.float32(self._threshold)), self._radius, float(_ROLL_OFF / (ratio * ratio))
            )
        part = self._roi
        if size != (width, height):
            growth = (np.float32(size[0]) / np.float32(width), np.float32(size[1]) / np.float32(height))
            resized = _whole(_native.resize(left.astype(np.float32), *size))
            left = _whole(resized.astype(np.float32) * growth[0])
            if weights is not None:
                weights = _native.resize(weights, *size)
            x, y, columns, rows = part
            part = (int(x * growth[0]), int(y * growth[1]), int(columns * growth[0]), int(rows * growth[1]))
        self._confidence = weights

        x, y, columns, rows = part
        inside = np.s_[y : y + rows, x : x + columns]
        guide = np.ascontiguousarray(view[inside].reshape(rows, columns, -1))
        values = left[inside].astype(np.float32)
        if weights is None:
            (smooth,) = _native.smooth(guide, [values], self._lambda, self._sigma)
        else:
            trusted = np.ascontiguousarray(weights[inside])
            product, trust = _native.smooth(guide, [trusted * values, trusted], self._lambda, self._sigma)
            # Where nothing is trusted, this is no number, or infinite.
            with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
                smooth = product * (np.float32(1.0) / (trust + _SMALLEST))
        filtered = np.full(left.shape, _OUTSIDE, np.int16)
        filtered[inside] = _whole(smooth)
        return into(filtered_disparity_map, filtered)

    def _part(self, given: Rect, width: int, height: int) -> Rect:
        if given[2] * given[3] == 0:
            left, right, top, bottom = self._margins
            given = (left, top, width - left - right, height - top - bottom)
        x, y, columns, rows = given
        if x < 0 or y < 0 or columns <= 0 or rows <= 0 or x + columns > width or y + rows > height:
            raise error(f"the part {given} (x, y, width, height) is not inside the map of {width} x {height} pixels")
        return given

    def getLambda(self) -> float:
        """How smooth the map becomes."""
        return self._lambda

    def setLambda(self, _lambda: float) -> None:
        """How smooth the map becomes."""
        self._lambda = _not_negative("_lambda", _lambda)

    def getSigmaColor(self) -> float:
        """The step of the image, in levels, that stops smoothing."""
        return self._sigma

    def setSigmaColor(self, _sigma_color: float) -> None:
        """The step of the image, in levels, that stops smoothing."""
        self._sigma = _not_negative("_sigma_color", _sigma_color)

    def getLRCthresh(self) -> int:
        """By how many 1/16 px left and right disparities differ at least to contradict each other."""
        return self._threshold

    def setLRCthresh(self, _LRC_thresh: int) -> None:
        """By how many 1/16 px left and right disparities differ at least to contradict each other."""
        self._threshold = integer("_LRC_thresh", _LRC_thresh)

    def getDepthDiscontinuityRadius(self) -> int:
        """The radius, in pixels, of the window whose variance lowers the confidence."""
        return self._radius

    def setDepthDiscontinuityRadius(self, _disc_radius: int) -> None:
        """The radius, in pixels, of the window whose variance lowers the confidence."""
        radius = integer("_disc_radius", _disc_radius)
        if not 0 <= radius <= 1000:
            raise error(f"the radius is {radius}; it is 0 to 1000 pixels")
        self._radius = radius

    def getConfidenceMap(self) -> npt.NDArray[np.float32] | None:
        """Of the last map that was filtered, float32, 0 to 255; None before, and of a filter without confidence."""
        return self._confidence

    def getROI(self) -> Rect:
        """The part of the last map that was filtered: x, y, width and height."""
        return self._roi


def createRightMatcher(matcher_left: StereoMatcher) -> StereoMatcher:
    """A matcher for the right view: it computes the pair (right, left), and its disparities are negative.

    >>> from gpu_stereo import cv
    >>> left = cv.StereoSGBM_create(0, 64, 5)
    >>> right = cv.ximgproc.createRightMatcher(left)
    >>> right.getMinDisparity(), right.getNumDisparities()
    (-63, 64)
    """
    minimum, count = matcher_left.getMinDisparity(), matcher_left.getNumDisparities()
    right: StereoBM | StereoSGBM
    if isinstance(matcher_left, StereoBM):
        right = StereoBM_create(count, matcher_left.getBlockSize())
        right.setMinDisparity(1 - minimum - count)
        right.setTextureThreshold(0)
    elif isinstance(matcher_left, StereoSGBM):
        right = StereoSGBM_create(1 - minimum - count, count, matcher_left.getBlockSize())
        right.setP1(matcher_left.getP1())
        right.setP2(matcher_left.getP2())
        right.setMode(matcher_left.getMode())
        right.setPreFilterCap(matcher_left.getPreFilterCap())
    else:
        raise error(f"createRightMatcher takes a StereoBM or a StereoSGBM, but is given a {type(matcher_left).__name__}")
    right.setUniquenessRatio(0)
    right.setDisp12MaxDiff(_UNCHECKED)
    right.setSpeckleWindowSize(0)
    return right


def createDisparityWLSFilter(matcher_left: StereoMatcher) -> DisparityWLSFilter:
    """The filter for maps of a matcher, whose own checks are switched off, as OpenCV does it.

    >>> from gpu_stereo import cv
    >>> matcher = cv.StereoSGBM_create(0, 64, 5, uniquenessRatio=10)
    >>> cv.ximgproc.createDisparityWLSFilter(matcher).getDepthDiscontinuityRadius(), matcher.getUniquenessRatio()
    (3, 0)
    """
    minimum, count = matcher_left.getMinDisparity(), matcher_left.getNumDisparities()
    block = matcher_left.getBlockSize()
    left, right = max(0, minimum + count), max(0, -minimum)
    if isinstance(matcher_left, StereoBM):
        reach = block // 2
        made = DisparityWLSFilter(True, (left + reach, right + reach, reach, reach))
        made.setDepthDiscontinuityRadius(math.ceil(0.33 * block))
        matcher_left.setTextureThreshold(0)
        matcher_left.setUniquenessRatio(0)
    elif isinstance(matcher_left, StereoSGBM):
        made = DisparityWLSFilter(True, (left, right, 0, 0))
        made.setDepthDiscontinuityRadius(max(0, math.ceil(0.5 * block)))
        matcher_left.setUniquenessRatio(0)
    else:
        raise error(f"createDisparityWLSFilter takes a StereoBM or a StereoSGBM, but is given a {type(matcher_left).__name__}")
    matcher_left.setDisp12MaxDiff(_UNCHECKED)
    matcher_left.setSpeckleWindowSize(0)
    return made


def createDisparityWLSFilterGeneric(use_confidence: bool) -> DisparityWLSFilter:
    """The filter for maps of any matcher; without confidence it needs no right map."""
    return DisparityWLSFilter(bool(use_confidence))


def getDisparityVis(src: Map, dst: Image | None = None, scale: float = 1.0) -> Image:
    """The map as a gray image of 8 bits: pixels times ``scale``. Equal to OpenCV's.

    >>> import numpy as np
    >>> from gpu_stereo import cv
    >>> cv.ximgproc.getDisparityVis(np.array([[16, 40, -16, 16320]], np.int16)).tolist()
    [[1, 2, 0, 0]]
    """
    given = map16("src", src)
    levels = np.rint(np.float32(number("scale", scale)) * given.astype(np.float32) / np.float32(16.0))
    levels = np.where(given == _UNKNOWN, 0, np.clip(levels, 0, 255))
    return into(dst, levels.astype(np.uint8))


def computeMSE(GT: Map, src: Map, ROI: Rect) -> float:
    """The mean square error of a map in a part of it, in px^2, where the truth is not 16320."""
    differences = _differences(GT, src, ROI)
    return float((differences * differences).sum() / (len(differences) * 256)) if len(differences) else math.nan


def computeBadPixelPercent(GT: Map, src: Map, ROI: Rect, thresh: int = 24) -> float:
    """How many per cent of the pixels in a part of a map are wrong by ``thresh`` / 16 px or more, where the truth is not 16320."""
    differences = _differences(GT, src, ROI)
    limit = integer("thresh", thresh)
    return float(100 * (np.abs(differences) >= limit).sum() / len(differences)) if len(differences) else math.nan


def _differences(GT: Map, src: Map, ROI: Rect) -> npt.NDArray[np.int64]:
    truth, given = map16("GT", GT), map16("src", src)
    x, y, width, height = rectangle("ROI", ROI)
    rows, columns = truth.shape
    if truth.shape != given.shape:
        raise error(f"GT has the shape {truth.shape}, src {given.shape}; they are required to be alike")
    if min(x, y, width, height) < 0 or x + width > columns or y + height > rows:
        raise error(f"ROI is {ROI} (x, y, width, height), which is not inside the map of {columns} x {rows} pixels")
    inside = np.s_[y : y + height, x : x + width]
    known = truth[inside] != _UNKNOWN
    differences: npt.NDArray[np.int64] = truth[inside][known].astype(np.int64) - given[inside][known]
    return differences


def _not_negative(name: str, value: float) -> float:
    given = number(name, value)
    if not 0 <= given < math.inf:
        raise error(f"{name} is {value}; it is a number that is not negative")
    return given


def _whole(values: npt.NDArray[Any]) -> Map:
    """The nearest int16, halves to even, as OpenCV's saturate_cast; the smallest one for what is no number of 32 bits."""
    rounded = np.rint(values)
    fits = np.abs(rounded) < 2.0**31
    return np.where(fits, np.clip(rounded, -32768, 32767), -32768).astype(np.int16)


def __getattr__(name: str) -> Any:
    """What this module does not have, of OpenCV's contributed modules."""
    if name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        from cv2 import ximgproc
    except ImportError:
        raise AttributeError(
            f"{__name__} has no {name!r}, and OpenCV's, from which it would come, is not installed: "
            "pip install opencv-contrib-python"
        ) from None
    return getattr(ximgproc, name)
