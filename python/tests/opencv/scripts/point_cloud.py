"""A pair, StereoSGBM, and a point cloud: LEFT RIGHT OUT_FOLDER. The test runs it with either import line."""

import sys
from pathlib import Path

import cv2 as cv
import numpy as np


def write_ply(path, points, colors):
    """Writes coloured points as text."""
    points, colors = points.reshape(-1, 3), colors.reshape(-1, 3)
    head = [
        "ply", "format ascii 1.0", f"element vertex {len(points)}",
        "property float x", "property float y", "property float z",
        "property uchar red", "property uchar green", "property uchar blue", "end_header",
    ]  # fmt: skip
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(head) + "\n")
        np.savetxt(file, np.hstack([points, colors]), fmt="%f %f %f %d %d %d")


def main(left_path, right_path, out):
    left, right = cv.imread(left_path), cv.imread(right_path)
    left, right = cv.pyrDown(left), cv.pyrDown(right)
    block, smallest, count = 3, 0, 48
    stereo = cv.StereoSGBM_create(
        minDisparity=smallest,
        numDisparities=count,
        blockSize=block,
        P1=8 * 3 * block**2,
        P2=32 * 3 * block**2,
        disp12MaxDiff=1,
        uniquenessRatio=10,
        speckleWindowSize=100,
        speckleRange=32,
    )
    disparity = stereo.compute(left, right).astype(np.float32) / 16.0

    height, width = left.shape[:2]
    focal = 0.8 * width
    Q = np.float32([
        [1, 0, 0, -0.5 * width],
        [0, -1, 0, 0.5 * height],  # y upwards
        [0, 0, 0, -focal],
        [0, 0, 1, 0],
    ])
    points = cv.reprojectImageTo3D(disparity, Q)
    colors = cv.cvtColor(left, cv.COLOR_BGR2RGB)
    mask = disparity > disparity.min()
    write_ply(out / "points.ply", points[mask], colors[mask])
    cv.imwrite(str(out / "disparity.png"), np.uint8(255 * np.clip((disparity - smallest) / count, 0, 1)))
    np.save(out / "disparity.npy", disparity)
    print(f"{mask.mean():.4f} {points[mask].shape[0]}")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], Path(sys.argv[3]))
