"""The matcher that computes a chain, kept from frame to frame."""

from __future__ import annotations

from typing import Any

import numpy as np

import gpu_stereo

from ._arrays import Image, Map, error
from ._settings import Chain

# What a raw map of gpu_stereo holds where there is no disparity.
INVALID = np.int16(-32768)

_device: int | str = "auto"
# The last few matchers that were used, the newest last: a left and a right one take turns.
_matchers: dict[Any, Any] = {}
_KEPT = 4


def setDevice(device: int | str) -> None:  # noqa: N802
    """Where all matchers of this module compute, as of gpu_stereo.StereoMatcher: auto, gpu, cpu, or an adapter's index or name."""
    global _device
    _device = device


def getDevice() -> int | str:  # noqa: N802
    """What setDevice has set; at first auto."""
    return _device


def match(left: Image, right: Image, chain: Chain) -> tuple[Map, Map]:
    """The left map in 1/16 px, without any filter, and the right view's whole disparities in 1/16 px."""
    key = (left.shape, chain.disparities, chain.options, _device)
    matcher = _matchers.pop(key, None)
    try:
        if matcher is None:
            matcher = gpu_stereo.StereoMatcher(
                left.shape[1],
                left.shape[0],
                preset="classic",
                disparities=chain.disparities,
                device=_device,
                channels="bgr",
                right_map=True,
                opencv_rules="on",
                lr_check="off",
                speckle_window="off",
                median="off",
                **dict(chain.options),
            )
        result = matcher.compute(left, right)
    except gpu_stereo.Error as refused:
        raise error(str(refused)) from refused
    _matchers[key] = matcher
    while len(_matchers) > _KEPT:
        del _matchers[next(iter(_matchers))]
    seen = np.where(np.isnan(result.right), INVALID, 16 * result.right)
    return result.raw, seen.astype(np.int16)
