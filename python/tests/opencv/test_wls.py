"""The filter by weighted least squares, beside ximgproc's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gpu_stereo import cv


def maps(cv2: Any, pair: Any, kind: str) -> tuple[Any, Any, Any]:
    """OpenCV's left and right map of a pair, and a matcher of ours with the same numbers."""
    if kind == "SGBM":
        matcher = cv2.StereoSGBM_create(0, 64, 5, 600, 2400, mode=cv2.StereoSGBM_MODE_SGBM_3WAY)
        ours = cv.StereoSGBM_create(0, 64, 5, 600, 2400, mode=cv.StereoSGBM_MODE_SGBM_3WAY)
    else:
        matcher, ours = cv2.StereoBM_create(64, 15), cv.StereoBM_create(64, 15)
    cv2.ximgproc.createDisparityWLSFilter(matcher)  # which switches its checks off
    left, right = pair
    return matcher.compute(left, right), cv2.ximgproc.createRightMatcher(matcher).compute(right, left), ours


def near(theirs: Any, ours: Any) -> None:
    """Equal but for the last bits of 32-bit floats, whose order OpenCV makes depend on the number of threads."""
    apart = np.abs(theirs.astype(int) - ours)
    assert apart.max() <= 1
    assert (apart != 0).mean() < 0.0005


@pytest.mark.parametrize("kind", ["SGBM", "BM"])
@pytest.mark.parametrize("color", [True, False])
@pytest.mark.parametrize("sigma", [1.0, 1.5])
def test_the_map_is_opencvs(cv2: Any, ximgproc: Any, pair: Any, gray_pair: Any, kind: str, color: bool, sigma: float) -> None:
    left_map, right_map, matcher = maps(cv2, gray_pair, kind)
    theirs = ximgproc.createDisparityWLSFilter(
        cv2.StereoSGBM_create(0, 64, 5) if kind == "SGBM" else cv2.StereoBM_create(64, 15)
    )
    ours = cv.ximgproc.createDisparityWLSFilter(matcher)
    view = (pair if color else gray_pair)[0]
    for filter_ in (theirs, ours):
        filter_.setSigmaColor(sigma)
    near(
        theirs.filter(left_map, view, disparity_map_right=right_map), ours.filter(left_map, view, disparity_map_right=right_map)
    )
    assert ours.getROI() == tuple(theirs.getROI())
    assert np.array_equal(ours.getConfidenceMap(), theirs.getConfidenceMap())
    assert ours.getConfidenceMap().max() > 100


def test_without_confidence_too(cv2: Any, ximgproc: Any, pair: Any, gray_pair: Any) -> None:
    left_map, _, _ = maps(cv2, gray_pair, "SGBM")
    theirs, ours = ximgproc.createDisparityWLSFilterGeneric(False), cv.ximgproc.createDisparityWLSFilterGeneric(False)
    part = (70, 10, 200, 150)
    near(theirs.filter(left_map, pair[0]), ours.filter(left_map, pair[0]))
    near(theirs.filter(left_map, pair[0], ROI=part), ours.filter(left_map, pair[0], ROI=part))
    assert ours.getROI() == part
    assert ours.getConfidenceMap() is None


def test_maps_of_half_the_size(cv2: Any, ximgproc: Any, pair: Any, gray_pair: Any) -> None:
    half = [image[::2, ::2].copy() for image in gray_pair]
    matcher = cv2.StereoSGBM_create(0, 32, 5, 600, 2400)
    theirs = ximgproc.createDisparityWLSFilter(matcher)
    left_map, right_map = matcher.compute(*half), ximgproc.createRightMatcher(matcher).compute(half[1], half[0])
    ours = cv.ximgproc.createDisparityWLSFilter(cv.StereoSGBM_create(0, 32, 5, 600, 2400))
    filtered = [one.filter(left_map, pair[0], disparity_map_right=right_map) for one in (theirs, ours)]
    # OpenCV's resize rounds halves of 16 bits by another rule.
    assert np.abs(filtered[0].astype(int) - filtered[1]).max() <= 1
    assert filtered[1].shape == pair[0].shape[:2]
    assert ours.getROI() == tuple(theirs.getROI())


def test_matchers_are_changed_as_by_opencv(cv2: Any, ximgproc: Any) -> None:
    for module_left, own in (
        (lambda module: module.StereoSGBM_create(-5, 48, 7, 100, 500, 2, 40, 12, 50, 3, 1), "StereoSGBM"),
        (lambda module: module.StereoBM_create(48, 11), "StereoBM"),
    ):
        theirs, ours = module_left(cv2), module_left(cv)
        right = [ximgproc.createRightMatcher(theirs), cv.ximgproc.createRightMatcher(ours)]
        filters = [ximgproc.createDisparityWLSFilter(theirs), cv.ximgproc.createDisparityWLSFilter(ours)]
        for name in (name for name in dir(cv2.StereoMatcher) + dir(getattr(cv2, own)) if name.startswith("get")):
            assert getattr(theirs, name)() == getattr(ours, name)(), name
            if hasattr(right[0], name):  # which is a plain StereoMatcher in Python
                assert getattr(right[0], name)() == getattr(right[1], name)(), name
        for name in ("getLambda", "getSigmaColor", "getLRCthresh", "getDepthDiscontinuityRadius"):
            assert getattr(filters[0], name)() == getattr(filters[1], name)(), name


def test_what_cannot_be_filtered_is_refused(pair: Any) -> None:
    view = pair[0]
    map = np.zeros(view.shape[:2], np.int16)
    generic = cv.ximgproc.createDisparityWLSFilterGeneric
    with pytest.raises(cv.error, match="disparity_map_right is missing"):
        generic(True).filter(map, view)
    with pytest.raises(cv.error, match="has the shape"):
        generic(True).filter(map, view, disparity_map_right=map[1:])
    with pytest.raises(cv.error, match="not inside the map"):
        generic(False).filter(map, view, ROI=(0, 0, 401, 10))
    with pytest.raises(cv.error, match="int16"):
        generic(False).filter(map.astype(np.float32), view)
    with pytest.raises(cv.error, match="uint8"):
        generic(False).filter(map, view.astype(np.uint16))
    with pytest.raises(cv.error, match="not negative"):
        generic(False).setLambda(-1.0)
