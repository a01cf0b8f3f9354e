"""OpenCV's functions of given maps."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _native
from ._arrays import Map, Rect, array, error, integer, map16, number, rectangle

# OpenCV's numbers of what is no float32.
_INTEGERS: dict[int, type[np.int16 | np.int32]] = {3: np.int16, 4: np.int32}
_FLOATS = (-1, 5)


def filterSpeckles(  # noqa: N802
    img: npt.NDArray[Any], newVal: float, maxSpeckleSize: int, maxDiff: float, buf: Any = None
) -> tuple[npt.NDArray[Any], Any]:
    """Sets small regions of a map to ``newVal``, in place. Equal to OpenCV's.

    ``img`` is int16 or uint8. Neighbours in a row or column are of one region if they differ by at most ``maxDiff``; what is
    ``newVal`` is of none. Regions of at most ``maxSpeckleSize`` pixels are small. ``buf`` is not needed and given back.

    >>> import numpy as np
    >>> from gpu_stereo import cv
    >>> map, _ = cv.filterSpeckles(np.array([[16, 16, 16, 80, 16]], np.int16), -16, 1, 16)
    >>> map.tolist()
    [[16, 16, 16, -16, -16]]
    """
    given = array("img", img, ["int16", "uint8"])
    # Python rounds halves to even, as OpenCV's cvRound does.
    invalid, largest = round(number("newVal", newVal)), integer("maxSpeckleSize", maxSpeckleSize)
    difference = round(number("maxDiff", maxDiff))
    allowed = np.iinfo(given.dtype)
    if not allowed.min <= invalid <= allowed.max:
        raise error(f"newVal is {newVal}; of {given.dtype} it is {allowed.min} to {allowed.max}")
    difference = max(-1, min(difference, 2**16))
    if not img.flags.writeable:
        raise error("img is changed in place, but can't be written; give a copy of it")
    compute = _native.filter_speckles_i16 if given.dtype == np.int16 else _native.filter_speckles_u8
    img[...] = compute(given, invalid, largest, difference).reshape(img.shape)
    return img, buf


def validateDisparity(  # noqa: N802
    disparity: Map,
    cost: npt.NDArray[Any],
    minDisparity: int,
    numberOfDisparities: int,
    disp12MaxDisp: int = 1,
) -> Map:
    """Makes disparities invalid, in place, that a cheaper match of the same right pixel contradicts. Equal to OpenCV's, which
    reads memory outside of the map where a disparity leads out of the image; here such a pixel takes no part.

    ``cost`` is int16 or int32, of the shape of ``disparity``: what each match costs.
    """
    given = map16("disparity", disparity)
    costs = array("cost", cost, ["int16", "int32"])
    minimum, count = integer("minDisparity", minDisparity), integer("numberOfDisparities", numberOfDisparities)
    if costs.shape != given.shape:
        raise error(f"cost has the shape {costs.shape}, disparity {given.shape}; they are required to be alike")
    if count <= 0:
        raise error(f"numberOfDisparities is {count}; it is required to be positive")
    if not -2048 <= minimum <= 2047:
        raise error(f"minDisparity is {minimum}; of maps in int16 it is -2048 to 2047")
    if not disparity.flags.writeable:
        raise error("disparity is changed in place, but can't be written; give a copy of it")
    difference = integer("disp12MaxDisp", disp12MaxDisp)
    checked = _native.validate_disparity(given, costs.astype(np.int32), minimum, min(count, 2**16), difference)
    disparity[...] = checked.reshape(disparity.shape)
    return disparity


def getValidDisparityROI(  # noqa: N802
    roi1: Rect, roi2: Rect, minDisparity: int, numberOfDisparities: int, blockSize: int
) -> Rect:
    """The part of the left image that has disparities, of the valid parts of both images. Equal to OpenCV's.

    >>> from gpu_stereo import cv
    >>> cv.getValidDisparityROI((0, 0, 640, 480), (0, 0, 640, 480), 0, 64, 15)
    (70, 7, 563, 466)
    """
    (x1, y1, width1, height1), (x2, y2, width2, height2) = rectangle("roi1", roi1), rectangle("roi2", roi2)
    # OpenCV divides towards zero.
    reach = int(integer("blockSize", blockSize) / 2)
    largest = integer("minDisparity", minDisparity) + integer("numberOfDisparities", numberOfDisparities) - 1
    left, top = max(x1, x2 + largest) + reach, max(y1, y2) + reach
    right, bottom = min(x1 + width1, x2 + width2) - reach, min(y1 + height1, y2 + height2) - reach
    if right <= left or bottom <= top:
        return 0, 0, 0, 0
    return left, top, right - left, bottom - top


def reprojectImageTo3D(  # noqa: N802
    disparity: npt.NDArray[Any],
    Q: npt.NDArray[Any],  # noqa: N803
    _3dImage: npt.NDArray[Any] | None = None,  # noqa: N803
    handleMissingValues: bool = False,
    ddepth: int = -1,
) -> npt.NDArray[Any]:
    """Height x width x 3: X, Y and Z of each pixel, of Q (x, y, disparity, 1). Equal to OpenCV's.

    ``disparity`` is uint8, int16, int32 or float32, and taken as pixels: a map of ``compute`` is divided by 16 before.
    With ``handleMissingValues`` the pixels of the smallest value get Z = 10000.

    >>> import numpy as np
    >>> from gpu_stereo import cv
    >>> Q = np.array([[1, 0, 0, -2], [0, 1, 0, -1], [0, 0, 0, 500], [0, 0, 10, 0]], float)
    >>> cv.reprojectImageTo3D(np.full((1, 1), 5, np.float32), Q).tolist()
    [[[-0.03999999910593033, -0.019999999552965164, 10.0]]]
    """
    given = array("disparity", disparity, ["uint8", "int16", "int32", "float32"])
    matrix = np.asarray(Q)
    if matrix.shape != (4, 4) or matrix.dtype.kind not in "fiu":
        raise error(f"Q is required to be 4 x 4 numbers, but is {matrix.dtype} of the shape {matrix.shape}")
    if ddepth not in _FLOATS and ddepth not in _INTEGERS:
        raise error(f"ddepth is {ddepth!r}; it is -1 or CV_32F (5) for float32, CV_16S (3) or CV_32S (4)")
    values = given.astype(np.float32)
    missing = float(given.min()) if handleMissingValues else None
    points: npt.NDArray[Any] = _native.reproject(values, matrix.astype(np.float64).tolist(), missing)
    depth = _INTEGERS.get(ddepth)
    if depth is not None:
        limits = np.iinfo(depth)
        rounded = np.clip(np.rint(points.astype(np.float64)), limits.min, limits.max)
        # OpenCV makes the smallest number of what is no number.
        points = np.where(np.isfinite(rounded), rounded, limits.min).astype(depth)
    if _3dImage is not None and _3dImage.shape == points.shape and _3dImage.dtype == points.dtype:
        _3dImage[...] = points
        return _3dImage
    return points
