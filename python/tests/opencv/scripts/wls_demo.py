"""Left and right maps and the WLS filter with its confidence: LEFT RIGHT OUT_FOLDER. The test runs it with either import line."""

import sys
from pathlib import Path

import cv2 as cv
import numpy as np


def main(left_path, right_path, out):
    left, right = cv.imread(left_path), cv.imread(right_path)
    block = 3
    matcher = cv.StereoSGBM_create(0, 64, block)
    matcher.setP1(24 * block * block)
    matcher.setP2(96 * block * block)
    matcher.setPreFilterCap(63)
    matcher.setMode(cv.StereoSGBM_MODE_SGBM_3WAY)
    wls = cv.ximgproc.createDisparityWLSFilter(matcher)
    wls.setLambda(8000.0)
    wls.setSigmaColor(1.5)
    left_map = matcher.compute(left, right)
    right_map = cv.ximgproc.createRightMatcher(matcher).compute(right, left)
    filtered = wls.filter(left_map, left, disparity_map_right=right_map)
    confidence = wls.getConfidenceMap()
    np.save(out / "filtered.npy", filtered)
    np.save(out / "confidence.npy", confidence)
    cv.imwrite(str(out / "raw.png"), cv.ximgproc.getDisparityVis(left_map, scale=4.0))
    cv.imwrite(str(out / "filtered.png"), cv.ximgproc.getDisparityVis(filtered, scale=4.0))
    print(wls.getROI(), f"{confidence.mean():.2f}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
