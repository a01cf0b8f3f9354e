"""What OpenCV's numbers mean for the chain of gpu_stereo."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ._arrays import error

# OpenCV's sums of costs are quantised by the chain so that the largest possible sum becomes this much (docs/ALGORITHMS.md,
# matching_cost). P1 and P2 are quantised alike.
_LARGEST_COST = 59 * 1550 / 1024
_LARGEST_P2 = 127
# Of the gray image, the second term of SGBM's cost, a quarter of the difference is added.
_GRAY_TERM = 63
_LARGEST_CAP = 96
_LARGEST_BLOCK = 51
_PATHS = {0: 5, 1: 8, 2: 3, 3: 4}


@dataclass(frozen=True)
class Chain:
    """Options of a matcher by the names of the command, and what is done to its map afterwards."""

    disparities: int
    options: tuple[tuple[str, Any], ...]
    warnings: tuple[str, ...] = ()


@dataclass
class SGBM:
    """The numbers of a StereoSGBM, as they were given."""

    minDisparity: int
    numDisparities: int
    blockSize: int
    P1: int
    P2: int
    disp12MaxDiff: int
    preFilterCap: int
    uniquenessRatio: int
    speckleWindowSize: int
    speckleRange: int
    mode: int


@dataclass
class BM:
    """The numbers of a StereoBM, as they were given."""

    minDisparity: int
    numDisparities: int
    blockSize: int
    disp12MaxDiff: int
    preFilterType: int
    preFilterSize: int
    preFilterCap: int
    textureThreshold: int
    uniquenessRatio: int
    speckleWindowSize: int
    speckleRange: int


def _within(name: str, value: int, smallest: int, largest: int) -> int:
    if not smallest <= value <= largest:
        raise error(f"{name} is {value}; this matcher takes {smallest} to {largest}")
    return value


def _range(minimum: int, count: int) -> list[tuple[str, Any]]:
    _within("minDisparity", minimum, -2047, 2047)
    _within("numDisparities", count, 1, 2048 - minimum)
    return [("min_disp", minimum)]


def quantised(block: int, cap: int, channels: int) -> float:
    """By how much a number in the unit of StereoSGBM's sums is multiplied to be one in the unit of the chain."""
    return _LARGEST_COST / (block * block * (2 * cap + _GRAY_TERM) * channels)


def sgbm(given: SGBM, channels: int) -> Chain:
    """The chain for a StereoSGBM on images of one or three channels."""
    options = _range(given.minDisparity, given.numDisparities)
    # As OpenCV replaces what is out of range.
    block = given.blockSize if given.blockSize > 0 else 5
    block = _within("blockSize", 2 * (block // 2) + 1, 1, _LARGEST_BLOCK)
    cap = _within("preFilterCap", max(given.preFilterCap, 15) | 1, 15, _LARGEST_CAP)
    p1 = given.P1 if given.P1 > 0 else 2
    p2 = max(given.P2 if given.P2 > 0 else 5, p1 + 1)
    uniqueness = given.uniquenessRatio if given.uniquenessRatio >= 0 else 10
    _within("uniquenessRatio", uniqueness, 0, 99)

    warnings: list[str] = []
    unit = quantised(block, cap, channels)
    exact = (p1 * unit, p2 * unit)
    chain_p1, chain_p2 = round(exact[0]), round(exact[1])
    if chain_p2 > _LARGEST_P2:
        chain_p2 = _LARGEST_P2
        warnings.append(
            f"P2 = {p2} is {exact[1]:.1f} in the unit of gpu_stereo, which ends at {_LARGEST_P2}: it counts as "
            f"{round(_LARGEST_P2 / unit)}. A larger P2 would make hardly any difference; with blockSize = {block}, "
            f"32 * {channels} * blockSize * blockSize = {32 * channels * block * block} is usual"
        )
    if chain_p1 > chain_p2:
        chain_p1 = chain_p2
    if chain_p1 <= 2 and exact[0] < 2.5:
        warnings.append(
            f"P1 = {p1} is {exact[0]:.2f} in the unit of gpu_stereo, whose numbers are whole: it counts as {chain_p1}. With "
            f"blockSize = {block}, 8 * {channels} * blockSize * blockSize = {8 * channels * block * block} is usual"
        )
    options += [
        ("method", "sgm"),
        ("cost", "bt-gray"),
        ("block", block),
        ("prefilter", "xsobel"),
        ("prefilter_cap", cap),
        ("p1", chain_p1),
        ("p2", chain_p2),
        ("paths", _PATHS.get(given.mode, 5)),
        ("uniqueness", uniqueness),
        ("subpixel", "parabola"),
    ]
    return Chain(given.numDisparities, tuple(options), tuple(warnings))


def bm(given: BM, size: tuple[int, int]) -> Chain:
    """The chain for a StereoBM on images of a width and a height, with OpenCV's refusals."""
    if given.preFilterType not in (0, 1):
        raise error(
            f"preFilterType is {given.preFilterType}; it is PREFILTER_NORMALIZED_RESPONSE (0) or PREFILTER_XSOBEL (1)"
        )
    if not 5 <= given.preFilterSize <= 255 or given.preFilterSize % 2 == 0:
        raise error(f"preFilterSize is {given.preFilterSize}; it is odd and 5 to 255")
    if not 1 <= given.preFilterCap <= 63:
        raise error(f"preFilterCap is {given.preFilterCap}; it is 1 to 63")
    if not 5 <= given.blockSize <= 255 or given.blockSize % 2 == 0 or given.blockSize >= min(size):
        raise error(
            f"blockSize is {given.blockSize}; it is odd, 5 to 255, and less than the {size[0]} x {size[1]} pixels of the images"
        )
    if given.numDisparities <= 0 or given.numDisparities % 16:
        raise error(f"numDisparities is {given.numDisparities}; it is positive and divisible by 16")
    if given.textureThreshold < 0:
        raise error(f"textureThreshold is {given.textureThreshold}; it is not negative")
    if given.uniquenessRatio < 0:
        raise error(f"uniquenessRatio is {given.uniquenessRatio}; it is not negative")
    _within("blockSize", given.blockSize, 5, _LARGEST_BLOCK)
    texture = _within("textureThreshold", given.textureThreshold, 0, 330_327)
    options = _range(given.minDisparity, given.numDisparities)
    if given.preFilterType == 0:
        options.append(("prefilter_window", _within("preFilterSize", given.preFilterSize, 5, _LARGEST_BLOCK)))
    options += [
        ("method", "bm"),
        ("cost", "sad"),
        ("block", given.blockSize),
        ("prefilter", "xsobel" if given.preFilterType == 1 else "normalized"),
        ("prefilter_cap", given.preFilterCap),
        # Of the normalized response the texture is another sum, which _matchers computes.
        ("texture", texture if given.preFilterType == 1 else 0),
        ("uniqueness", _within("uniquenessRatio", given.uniquenessRatio, 0, 99)),
        ("subpixel", "equiangular"),
    ]
    return Chain(given.numDisparities, tuple(options))
