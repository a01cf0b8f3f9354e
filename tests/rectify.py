"""The rectification of docs/ALGORITHMS.md, as tests/algorithms.py has it, beside OpenCV's: within one gray level.

    python3 rectify.py

Needs OpenCV 5, whose remap takes positions as they are (before, in 1/32 px), and NumPy; without them says so and stops with 3.
"""

import sys

try:
    import cv2
    import numpy

    if int(cv2.__version__.split(".")[0]) < 5:
        raise ImportError("OpenCV is %s, but 5 is needed" % cv2.__version__)
except ImportError as error:
    print("NOT TESTED: rectify beside OpenCV, %s" % error, file=sys.stderr)
    sys.exit(3)

from algorithms import Chain, EXAMPLE


def rotation(*angles):
    return cv2.Rodrigues(numpy.array(angles))[0]


def main():
    width, height = 157, 93
    numbers = numpy.random.default_rng(1)
    worst = 0
    for case in range(24):
        distortion = numpy.zeros(8)
        count = (4, 5, 8)[case % 3]
        distortion[:count] = numbers.uniform(-1, 1, count) * numpy.array([0.3, 0.1, 2e-3, 2e-3, 0.05, 0.3, 0.1, 0.02])[:count]
        matrix = numpy.array([[0.9 * width, 0, 0.48 * width], [0, 0.92 * width, 0.53 * height], [0, 0, 1]])
        turned = rotation(*numbers.uniform(-0.05, 0.05, 3))
        projection = numpy.array([[0.95 * width, 0, 0.5 * width], [0, 0.95 * width, 0.5 * height], [0, 0, 1]])
        kind, dtype, largest, depth = [("gray8", "uint8", 255, 1), ("rgba16", "uint16", 65535, 4), ("rgba8", "uint8", 255, 4),
            ("gray16", "uint16", 65535, 1)][case % 4]
        # A smooth image with a step: noise alone would show any rounding of positions at its largest.
        y, x = numpy.mgrid[0:height, 0:width]
        smooth = (numpy.sin(x / 9 + case) + numpy.cos(y / 7) + (x > width // 2)) / 4 + 0.4
        image = numpy.repeat((smooth.clip(0, 1) * largest).astype(dtype)[:, :, None], depth, 2)
        map_x, map_y = cv2.initUndistortRectifyMap(
            matrix, distortion[: max(count, 4)], turned, projection, (width, height), cv2.CV_32FC1)
        expected = cv2.remap(image, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
        lens = {
            "matrix": matrix.ravel().tolist(), "distortion": distortion.tolist(), "rotation": turned.ravel().tolist(),
            "projection": projection.ravel().tolist(),
        }
        chain = Chain({**EXAMPLE, "width": width, "height": height, "format": kind})
        places = numpy.array(chain.positions(lens)).reshape(height, width, 2) / 256
        off = max(abs(places[:, :, 0] - map_x.clip(-2, width)).max(), abs(places[:, :, 1] - map_y.clip(-2, height)).max())
        assert off <= 1 / 512 + 1e-3, off
        found = numpy.array(chain.rectify(lens, image.ravel().tolist())).reshape(expected.shape[:2] + (depth,))
        unit = 257 if largest == 65535 else 1
        inside = (places[:, :, 0] >= 0) & (places[:, :, 0] <= width - 1) & (places[:, :, 1] >= 0) & (places[:, :, 1] <= height - 1)
        difference = abs(found - expected.reshape(found.shape).astype(int)).max(2) / unit
        print("case %2d, %-6s, %d numbers: inside %.3f levels at most, near the border %.3f" % (
            case, kind, count, difference[inside].max(), difference[~inside].max() if (~inside).any() else 0))
        worst = max(worst, difference[inside].max())
    assert 0 < inside.sum() < width * height
    assert worst <= 1, worst
    print("%.3f gray levels at most, with OpenCV %s" % (worst, cv2.__version__))


if __name__ == "__main__":
    main()
