"""OpenCV's stereo functions, computed by gpu_stereo: ``import gpu_stereo.cv as cv`` in place of ``import cv2 as cv``.

What is not here is OpenCV's own: ``cv.imread`` is ``cv2.imread``, where OpenCV is installed. docs/OPENCV.md says what is equal to
OpenCV to the bit, what is equivalent, and what differs by how much.
"""

from __future__ import annotations

from typing import Any

from . import ximgproc
from ._arrays import error
from ._engine import getDevice, setDevice
from ._maps import filterSpeckles, getValidDisparityROI, reprojectImageTo3D, validateDisparity
from ._matchers import StereoBM, StereoBM_create, StereoMatcher, StereoSGBM, StereoSGBM_create

STEREO_SGBM_MODE_SGBM = StereoSGBM_MODE_SGBM = StereoSGBM.MODE_SGBM
STEREO_SGBM_MODE_HH = StereoSGBM_MODE_HH = StereoSGBM.MODE_HH
STEREO_SGBM_MODE_SGBM_3WAY = StereoSGBM_MODE_SGBM_3WAY = StereoSGBM.MODE_SGBM_3WAY
STEREO_SGBM_MODE_HH4 = StereoSGBM_MODE_HH4 = StereoSGBM.MODE_HH4
STEREO_BM_PREFILTER_NORMALIZED_RESPONSE = StereoBM.PREFILTER_NORMALIZED_RESPONSE
StereoBM_PREFILTER_NORMALIZED_RESPONSE = StereoBM.PREFILTER_NORMALIZED_RESPONSE
STEREO_BM_PREFILTER_XSOBEL = StereoBM_PREFILTER_XSOBEL = StereoBM.PREFILTER_XSOBEL
STEREO_MATCHER_DISP_SHIFT = StereoMatcher_DISP_SHIFT = StereoMatcher.DISP_SHIFT
STEREO_MATCHER_DISP_SCALE = StereoMatcher_DISP_SCALE = StereoMatcher.DISP_SCALE

__all__ = [
    "StereoBM",
    "StereoBM_create",
    "StereoMatcher",
    "StereoSGBM",
    "StereoSGBM_create",
    "error",
    "filterSpeckles",
    "getDevice",
    "getValidDisparityROI",
    "reprojectImageTo3D",
    "setDevice",
    "validateDisparity",
    "ximgproc",
]


def __getattr__(name: str) -> Any:
    """What this module does not have, of OpenCV."""
    if name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    try:
        import cv2
    except ImportError:
        raise AttributeError(
            f"{__name__} has no {name!r}, and OpenCV, from which it would come, is not installed: pip install opencv-python"
        ) from None
    return getattr(cv2, name)
