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


RANGES = numpy.array([0.3, 0.1, 2e-3, 2e-3, 0.05, 0.3, 0.1, 0.02, 0.02, 0.01, 0.02, 0.01, 0.1, 0.1])
WIDTH, HEIGHT = 157, 93


def pinhole(case, numbers):
    """A lens of 4, 5, 8, 12 or 14 numbers, and where OpenCV looks."""
    count = (4, 5, 8, 12, 14)[case % 5]
    distortion = numpy.zeros(14)
    distortion[:count] = numbers.uniform(-1, 1, count) * RANGES[:count]
    matrix = numpy.array([[0.9 * WIDTH, 0, 0.48 * WIDTH], [0, 0.92 * WIDTH, 0.53 * HEIGHT], [0, 0, 1]])
    turned = rotation(*numbers.uniform(-0.05, 0.05, 3))
    projection = numpy.array([[0.95 * WIDTH, 0, 0.5 * WIDTH], [0, 0.95 * WIDTH, 0.5 * HEIGHT], [0, 0, 1]])
    maps = cv2.initUndistortRectifyMap(matrix, distortion[:count], turned, projection, (WIDTH, HEIGHT), cv2.CV_32FC1)
    lens = {"pinhole": distortion.tolist()}
    return "%d numbers" % count, lens, matrix, turned, projection, maps


def fisheye(case, numbers):
    """A lens that sees up to 180 degrees across, turned by up to 100: much of what is asked for lies behind it."""
    distortion = numbers.uniform(-1, 1, 4) * numpy.array([0.03, 0.02, 0.02, 0.01])
    focal = WIDTH / numpy.pi * (1, 1.5, 3)[case % 3]
    matrix = numpy.array([[focal, 0, 0.48 * WIDTH], [0, 1.02 * focal, 0.53 * HEIGHT], [0, 0, 1]])
    largest = (0.05, 0.4, 1.2)[case % 3]
    turned = rotation(*numbers.uniform(-largest, largest, 3))
    wide = (0.9, 0.4, 0.15)[case % 3]
    projection = numpy.array([[wide * WIDTH, 0, 0.5 * WIDTH], [0, wide * WIDTH, 0.5 * HEIGHT], [0, 0, 1]])
    maps = cv2.fisheye.initUndistortRectifyMap(matrix, distortion, turned, projection, (WIDTH, HEIGHT), cv2.CV_32FC1)
    return "fisheye", {"fisheye": distortion.tolist()}, matrix, turned, projection, maps


def main():
    numbers = numpy.random.default_rng(1)
    worst, worst_off, behind = 0, 0, 0
    for case in range(36):
        name, lens, matrix, turned, projection, (map_x, map_y) = (pinhole, fisheye)[case >= 24](case, numbers)
        kind, dtype, largest, depth = [("gray8", "uint8", 255, 1), ("rgba16", "uint16", 65535, 4), ("rgba8", "uint8", 255, 4),
            ("gray16", "uint16", 65535, 1)][case % 4]
        # A smooth image with a step: noise alone would show any rounding of positions at its largest.
        y, x = numpy.mgrid[0:HEIGHT, 0:WIDTH]
        smooth = (numpy.sin(x / 9 + case) + numpy.cos(y / 7) + (x > WIDTH // 2)) / 4 + 0.4
        image = numpy.repeat((smooth.clip(0, 1) * largest).astype(dtype)[:, :, None], depth, 2)
        expected = cv2.remap(image, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
        lens |= {"matrix": matrix.ravel().tolist(), "rotation": turned.ravel().tolist(), "projection": projection.ravel().tolist()}
        chain = Chain({**EXAMPLE, "width": WIDTH, "height": HEIGHT})
        places = numpy.array(chain.positions(lens)).reshape(HEIGHT, WIDTH, 2) / 256
        # Behind the camera OpenCV has an infinite position, or that of the opposite direction.
        back = (numpy.linalg.inv(projection @ turned) @ numpy.array([x.ravel(), y.ravel(), 0 * x.ravel() + 1]))[2].reshape(x.shape)
        ahead = back > 0
        behind += int((~ahead).sum())
        assert (places[~ahead] == -2).all()
        off = max(
            abs(places[:, :, axis] - given.clip(-2, side))[ahead].max()
            for axis, given, side in ((0, map_x, WIDTH), (1, map_y, HEIGHT)))
        assert off <= 1 / 512 + 1e-3, off
        found = numpy.array(chain.rectify(lens, kind, image.ravel().tolist())).reshape(expected.shape[:2] + (depth,))
        unit = 257 if largest == 65535 else 1
        inside = (places[:, :, 0] >= 0) & (places[:, :, 0] <= WIDTH - 1) & (places[:, :, 1] >= 0) & (places[:, :, 1] <= HEIGHT - 1)
        difference = abs(found - expected.reshape(found.shape).astype(int)).max(2) / unit
        print("case %2d, %-6s, %10s: %3.0f %% inside, %.4f px and %.3f levels off at most, near the border %.3f levels" % (
            case, kind, name, 100 * inside.mean(), off, difference[inside].max(), difference[~inside].max() if (~inside).any() else 0))
        assert inside.any()
        worst, worst_off = max(worst, difference[inside].max()), max(worst_off, off)
    assert behind > 0
    assert worst <= 1, worst
    print("%.4f px and %.3f gray levels at most, with OpenCV %s" % (worst_off, worst, cv2.__version__))


if __name__ == "__main__":
    main()
