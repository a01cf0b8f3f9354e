"""StereoSGBM and StereoBM with OpenCV's numbers, computed by gpu_stereo."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _native
from ._arrays import Image, Map, Rect, error, image, into, integer, rectangle
from ._engine import INVALID, match
from ._maps import filterSpeckles, getValidDisparityROI
from ._settings import BM, SGBM, bm, sgbm

# ruff: noqa: N802, N803, N815 - OpenCV's names


class StereoMatcher:
    """What StereoSGBM and StereoBM have in common."""

    DISP_SHIFT = 4
    DISP_SCALE = 16
    _name = "StereoMatcher"
    _saved: tuple[str, ...] = ()

    def __init__(self, numbers: Any) -> None:
        self._numbers = numbers

    def compute(self, left: Image, right: Image, disparity: Map | None = None) -> Map:
        """The map of a rectified pair: int16, height x width, in 1/16 px; (minDisparity - 1) * 16 where there is none.

        ``disparity`` is filled and returned if it is int16 of that shape.
        """
        raise NotImplementedError

    def clear(self) -> None:
        """Nothing: there is no state but the numbers."""

    def empty(self) -> bool:
        """False."""
        return False

    def getDefaultName(self) -> str:
        """OpenCV's name of an object in a file."""
        return "my_object"

    def save(self, filename: str) -> None:
        """Writes the numbers as OpenCV does, a YAML that its ``read`` takes."""
        lines = ["%YAML 1.2", "---", "my_object:", "   format: 3", f'   name: "{self._name}"']
        lines += [f"   {name}: {getattr(self._numbers, name)}" for name in self._saved]
        Path(filename).write_text("\n".join(lines) + "\n", encoding="utf-8")

    def _invalid(self) -> int:
        return (int(self._numbers.minDisparity) - 1) * self.DISP_SCALE

    def getMinDisparity(self) -> int:
        """The smallest disparity, in pixels."""
        return int(self._numbers.minDisparity)

    def setMinDisparity(self, minDisparity: int) -> None:
        """The smallest disparity, in pixels."""
        self._numbers.minDisparity = integer("minDisparity", minDisparity)

    def getNumDisparities(self) -> int:
        """The number of disparities, in pixels."""
        return int(self._numbers.numDisparities)

    def setNumDisparities(self, numDisparities: int) -> None:
        """The number of disparities, in pixels."""
        self._numbers.numDisparities = integer("numDisparities", numDisparities)

    def getBlockSize(self) -> int:
        """The side of a block, in pixels."""
        return int(self._numbers.blockSize)

    def setBlockSize(self, blockSize: int) -> None:
        """The side of a block, in pixels."""
        self._numbers.blockSize = integer("blockSize", blockSize)

    def getDisp12MaxDiff(self) -> int:
        """By how many pixels left and right may differ."""
        return int(self._numbers.disp12MaxDiff)

    def setDisp12MaxDiff(self, disp12MaxDiff: int) -> None:
        """By how many pixels left and right may differ."""
        self._numbers.disp12MaxDiff = integer("disp12MaxDiff", disp12MaxDiff)

    def getSpeckleWindowSize(self) -> int:
        """The pixels of the largest speckle; 0 for no filter."""
        return int(self._numbers.speckleWindowSize)

    def setSpeckleWindowSize(self, speckleWindowSize: int) -> None:
        """The pixels of the largest speckle; 0 for no filter."""
        self._numbers.speckleWindowSize = integer("speckleWindowSize", speckleWindowSize)

    def getSpeckleRange(self) -> int:
        """By how much neighbours of one speckle differ: in pixels with StereoSGBM, in 1/16 px with StereoBM."""
        return int(self._numbers.speckleRange)

    def setSpeckleRange(self, speckleRange: int) -> None:
        """By how much neighbours of one speckle differ: in pixels with StereoSGBM, in 1/16 px with StereoBM."""
        self._numbers.speckleRange = integer("speckleRange", speckleRange)


class _Matcher(StereoMatcher):
    """What both have beyond OpenCV's StereoMatcher."""

    def getPreFilterCap(self) -> int:
        """The clip of the horizontal derivative."""
        return int(self._numbers.preFilterCap)

    def setPreFilterCap(self, preFilterCap: int) -> None:
        """The clip of the horizontal derivative."""
        self._numbers.preFilterCap = integer("preFilterCap", preFilterCap)

    def getUniquenessRatio(self) -> int:
        """By how many per cent the best match is ahead."""
        return int(self._numbers.uniquenessRatio)

    def setUniquenessRatio(self, uniquenessRatio: int) -> None:
        """By how many per cent the best match is ahead."""
        self._numbers.uniquenessRatio = integer("uniquenessRatio", uniquenessRatio)


class StereoSGBM(_Matcher):
    """Semi-global matching with OpenCV's numbers; see docs/OPENCV.md for what is equal and what differs."""

    MODE_SGBM = 0
    MODE_HH = 1
    MODE_SGBM_3WAY = 2
    MODE_HH4 = 3
    _name = "StereoMatcher.SGBM"
    _saved = (
        "minDisparity", "numDisparities", "blockSize", "speckleWindowSize", "speckleRange", "disp12MaxDiff", "preFilterCap",
        "uniquenessRatio", "P1", "P2", "mode",
    )  # fmt: skip
    _numbers: SGBM

    @staticmethod
    def create(
        minDisparity: int = 0,
        numDisparities: int = 16,
        blockSize: int = 3,
        P1: int = 0,
        P2: int = 0,
        disp12MaxDiff: int = 0,
        preFilterCap: int = 0,
        uniquenessRatio: int = 0,
        speckleWindowSize: int = 0,
        speckleRange: int = 0,
        mode: int = 0,
    ) -> StereoSGBM:
        """As StereoSGBM_create."""
        given = dict(locals())
        return StereoSGBM(SGBM(**{name: integer(name, value) for name, value in given.items()}))

    def compute(self, left: Image, right: Image, disparity: Map | None = None) -> Map:
        """The map of a rectified pair: int16, height x width, in 1/16 px; (minDisparity - 1) * 16 where there is none.

        ``left`` and ``right`` are uint8, height x width or height x width x 3. ``disparity`` is filled and returned if it is
        int16 of that shape.
        """
        left, right = _pair(left, right, (1, 3))
        numbers = self._numbers
        chain = sgbm(numbers, 1 if left.ndim == 2 else 3)
        first, behind = numbers.minDisparity, numbers.minDisparity + numbers.numDisparities
        reach = (numbers.blockSize if numbers.blockSize > 0 else 5) // 2
        if left.shape[1] - behind <= reach or left.shape[1] + min(first, 0) <= max(behind, 0):
            raise error(
                f"the images have {left.shape[1]} columns, which are too few for minDisparity {first}, numDisparities "
                f"{numbers.numDisparities} and blockSize {numbers.blockSize}"
            )
        for text in chain.warnings:
            warnings.warn(text, stacklevel=2)
        map, seen = _matched(left, right, chain, self._invalid())
        difference = numbers.disp12MaxDiff if numbers.disp12MaxDiff > 0 else 1
        map = _native.check_against_right(map, seen, numbers.minDisparity, numbers.numDisparities, difference, True)
        map = _native.median_3x3(map)
        if numbers.speckleWindowSize > 0:
            filterSpeckles(map, self._invalid(), numbers.speckleWindowSize, self.DISP_SCALE * numbers.speckleRange)
        return into(disparity, map)

    def getP1(self) -> int:
        """The penalty of a step of one disparity."""
        return int(self._numbers.P1)

    def setP1(self, P1: int) -> None:
        """The penalty of a step of one disparity."""
        self._numbers.P1 = integer("P1", P1)

    def getP2(self) -> int:
        """The penalty of a larger step."""
        return int(self._numbers.P2)

    def setP2(self, P2: int) -> None:
        """The penalty of a larger step."""
        self._numbers.P2 = integer("P2", P2)

    def getMode(self) -> int:
        """One of MODE_SGBM, MODE_HH, MODE_SGBM_3WAY and MODE_HH4."""
        return int(self._numbers.mode)

    def setMode(self, mode: int) -> None:
        """One of MODE_SGBM, MODE_HH, MODE_SGBM_3WAY and MODE_HH4."""
        self._numbers.mode = integer("mode", mode)


class StereoBM(_Matcher):
    """Block matching with OpenCV's numbers; see docs/OPENCV.md for what is equal and what differs."""

    PREFILTER_NORMALIZED_RESPONSE = 0
    PREFILTER_XSOBEL = 1
    _name = "StereoMatcher.BM"
    _saved = (
        "minDisparity", "numDisparities", "blockSize", "speckleWindowSize", "speckleRange", "disp12MaxDiff", "preFilterType",
        "preFilterSize", "preFilterCap", "textureThreshold", "uniquenessRatio",
    )  # fmt: skip
    _numbers: BM

    def __init__(self, numbers: BM) -> None:
        super().__init__(numbers)
        self._rois: list[Rect] = [(0, 0, 0, 0), (0, 0, 0, 0)]

    @staticmethod
    def create(numDisparities: int = 0, blockSize: int = 21) -> StereoBM:
        """As StereoBM_create."""
        count = integer("numDisparities", numDisparities)
        return StereoBM(
            BM(
                minDisparity=0,
                numDisparities=count if count > 0 else 64,
                blockSize=integer("blockSize", blockSize),
                disp12MaxDiff=-1,
                preFilterType=StereoBM.PREFILTER_XSOBEL,
                preFilterSize=9,
                preFilterCap=31,
                textureThreshold=10,
                uniquenessRatio=15,
                speckleWindowSize=0,
                speckleRange=0,
            )
        )

    def compute(self, left: Image, right: Image, disparity: Map | None = None) -> Map:
        """The map of a rectified pair: int16, height x width, in 1/16 px; (minDisparity - 1) * 16 where there is none.

        ``left`` and ``right`` are uint8, height x width. ``disparity`` is filled and returned if it is int16 of that shape.
        """
        left, right = _pair(left, right, (1,))
        numbers = self._numbers
        height, width = left.shape
        chain = bm(numbers, (width, height))
        invalid = self._invalid()
        # OpenCV asks for this many columns, which are not those of its valid rectangle.
        largest = numbers.minDisparity + numbers.numDisparities - 1
        if max(largest, 0) >= width or width + min(largest, 0) - numbers.numDisparities + 1 < 1:
            return into(disparity, np.full(left.shape, invalid, np.int16))
        map, seen = _matched(left, right, chain, invalid)
        if numbers.preFilterType == self.PREFILTER_NORMALIZED_RESPONSE and numbers.textureThreshold > 0:
            texture = _native.texture_of_response(left, numbers.preFilterSize, numbers.preFilterCap, numbers.blockSize)
            map[texture < numbers.textureThreshold] = invalid
        if numbers.disp12MaxDiff >= 0:
            map = _native.check_against_right(
                map, seen, numbers.minDisparity, numbers.numDisparities, numbers.disp12MaxDiff, False
            )
        whole = (0, 0, width, height)
        first, second = (roi if roi[2] > 0 and roi[3] > 0 else whole for roi in self._rois)
        x, y, columns, rows = getValidDisparityROI(
            first, second, numbers.minDisparity, numbers.numDisparities, numbers.blockSize
        )
        # Not beyond the images, whatever the two rectangles are.
        top, bottom, start, end = max(y, 0), max(y + rows, 0), max(x, 0), max(x + columns, 0)
        kept = np.full(map.shape, invalid, np.int16)
        kept[top:bottom, start:end] = map[top:bottom, start:end]
        if numbers.speckleWindowSize > 0 and numbers.speckleRange >= 0:
            filterSpeckles(kept, invalid, numbers.speckleWindowSize, numbers.speckleRange)
        return into(disparity, kept)

    def getPreFilterType(self) -> int:
        """PREFILTER_XSOBEL or PREFILTER_NORMALIZED_RESPONSE."""
        return int(self._numbers.preFilterType)

    def setPreFilterType(self, preFilterType: int) -> None:
        """PREFILTER_XSOBEL or PREFILTER_NORMALIZED_RESPONSE."""
        self._numbers.preFilterType = integer("preFilterType", preFilterType)

    def getPreFilterSize(self) -> int:
        """The window of PREFILTER_NORMALIZED_RESPONSE, in pixels."""
        return int(self._numbers.preFilterSize)

    def setPreFilterSize(self, preFilterSize: int) -> None:
        """The window of PREFILTER_NORMALIZED_RESPONSE, in pixels."""
        self._numbers.preFilterSize = integer("preFilterSize", preFilterSize)

    def getTextureThreshold(self) -> int:
        """The sum of derivatives below which a block has no texture."""
        return int(self._numbers.textureThreshold)

    def setTextureThreshold(self, textureThreshold: int) -> None:
        """The sum of derivatives below which a block has no texture."""
        self._numbers.textureThreshold = integer("textureThreshold", textureThreshold)

    def getSmallerBlockSize(self) -> int:
        """0, as in OpenCV."""
        return 0

    def setSmallerBlockSize(self, blockSize: int) -> None:
        """Nothing, as in OpenCV."""
        integer("blockSize", blockSize)

    def getROI1(self) -> Rect:
        """The part of the left image that is valid; (0, 0, 0, 0) for all of it."""
        return self._rois[0]

    def setROI1(self, roi1: Rect) -> None:
        """The part of the left image that is valid; (0, 0, 0, 0) for all of it."""
        self._rois[0] = rectangle("roi1", roi1)

    def getROI2(self) -> Rect:
        """The part of the right image that is valid; (0, 0, 0, 0) for all of it."""
        return self._rois[1]

    def setROI2(self, roi2: Rect) -> None:
        """The part of the right image that is valid; (0, 0, 0, 0) for all of it."""
        self._rois[1] = rectangle("roi2", roi2)


def StereoSGBM_create(
    minDisparity: int = 0,
    numDisparities: int = 16,
    blockSize: int = 3,
    P1: int = 0,
    P2: int = 0,
    disp12MaxDiff: int = 0,
    preFilterCap: int = 0,
    uniquenessRatio: int = 0,
    speckleWindowSize: int = 0,
    speckleRange: int = 0,
    mode: int = 0,
) -> StereoSGBM:
    """A StereoSGBM, with OpenCV's keywords and defaults.

    >>> import numpy as np
    >>> from gpu_stereo import cv
    >>> right = np.random.default_rng(0).integers(0, 256, (40, 80), np.uint8)
    >>> left = np.roll(right, 5, axis=1)
    >>> matcher = cv.StereoSGBM_create(numDisparities=16, blockSize=5, P1=600, P2=2400)
    >>> int(np.median(matcher.compute(left, right))) / 16
    5.0
    """
    return StereoSGBM.create(
        minDisparity, numDisparities, blockSize, P1, P2, disp12MaxDiff, preFilterCap, uniquenessRatio, speckleWindowSize,
        speckleRange, mode,
    )  # fmt: skip


def StereoBM_create(numDisparities: int = 0, blockSize: int = 21) -> StereoBM:
    """A StereoBM, with OpenCV's keywords and defaults.

    >>> import numpy as np
    >>> from gpu_stereo import cv
    >>> right = np.random.default_rng(0).integers(0, 256, (40, 80), np.uint8)
    >>> left = np.roll(right, 5, axis=1)
    >>> float(np.median(cv.StereoBM_create(16, 9).compute(left, right)[10:-10, 30:-10])) / 16
    5.0
    """
    return StereoBM.create(numDisparities, blockSize)


def _pair(left: Any, right: Any, channels: tuple[int, ...]) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8]]:
    left, right = image("left", left, channels), image("right", right, channels)
    if left.shape != right.shape:
        raise error(f"left has the shape {left.shape}, right {right.shape}; they are required to be alike")
    return left, right


def _matched(left: Image, right: Image, chain: Any, invalid: int) -> tuple[Map, Map]:
    """The map of the chain with OpenCV's invalid value, and the right view's."""
    raw, seen = match(left, right, chain)
    return np.where(raw == INVALID, np.int16(invalid), raw), seen
