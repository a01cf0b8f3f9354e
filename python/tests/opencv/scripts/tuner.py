"""StereoBM with the values that trackbars give: LEFT RIGHT OUT_FOLDER. The test runs it with either import line."""

import sys
from pathlib import Path

import cv2 as cv
import numpy as np

# A line for each position of the trackbars.
POSITIONS = [
    {"numDisparities": 4, "blockSize": 5},
    {"numDisparities": 4, "blockSize": 2, "uniquenessRatio": 0, "textureThreshold": 0},
    {"numDisparities": 3, "blockSize": 8, "preFilterType": 0, "preFilterSize": 2, "preFilterCap": 31},
    {"numDisparities": 4, "blockSize": 5, "preFilterCap": 63, "minDisparity": 4, "speckleRange": 16, "speckleWindowSize": 40},
    {"numDisparities": 4, "blockSize": 5, "disp12MaxDiff": 5, "textureThreshold": 100, "uniquenessRatio": 25},
]
DEFAULTS = {
    "numDisparities": 1, "blockSize": 5, "preFilterType": 1, "preFilterSize": 2, "preFilterCap": 5, "textureThreshold": 10,
    "uniquenessRatio": 15, "speckleRange": 0, "speckleWindowSize": 3, "disp12MaxDiff": -1, "minDisparity": 0,
}  # fmt: skip


def main(left_path, right_path, out):
    left = cv.cvtColor(cv.imread(left_path), cv.COLOR_BGR2GRAY)
    right = cv.cvtColor(cv.imread(right_path), cv.COLOR_BGR2GRAY)
    stereo = cv.StereoBM_create()
    for number, position in enumerate(POSITIONS):
        value = DEFAULTS | position
        # A trackbar starts at 0 and has every value.
        stereo.setNumDisparities(value["numDisparities"] * 16)
        stereo.setBlockSize(value["blockSize"] * 2 + 5)
        stereo.setPreFilterType(value["preFilterType"])
        stereo.setPreFilterSize(value["preFilterSize"] * 2 + 5)
        stereo.setPreFilterCap(value["preFilterCap"])
        stereo.setTextureThreshold(value["textureThreshold"])
        stereo.setUniquenessRatio(value["uniquenessRatio"])
        stereo.setSpeckleRange(value["speckleRange"])
        stereo.setSpeckleWindowSize(value["speckleWindowSize"] * 2)
        stereo.setDisp12MaxDiff(value["disp12MaxDiff"])
        stereo.setMinDisparity(value["minDisparity"])
        disparity = stereo.compute(left, right).astype(np.float32)
        np.save(out / f"tuned{number}.npy", disparity)
        shown = (disparity / 16.0 - stereo.getMinDisparity()) / stereo.getNumDisparities()
        cv.imwrite(str(out / f"tuned{number}.png"), np.uint8(255 * np.clip(shown, 0, 1)))
        print(f"{number} {(disparity >= 16 * value['minDisparity']).mean():.4f}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
