"""How often the disparity of the smallest pixel cost alone is wrong: what a cost is worth before anything is made of it."""

import numpy as np


def by_dots(left, right, disparities):
    """The best disparity of each pixel by the largest product of features [channel][y][x]; the lowest of equals."""
    _, height, width = left.shape
    x = np.arange(width)
    partner = np.maximum(0, x[:, None] - np.arange(disparities)[None])
    best = np.empty((height, width), np.int64)
    for y in range(height):
        dots = left[:, y].T.astype(np.float32) @ right[:, y].astype(np.float32)
        best[y] = np.take_along_axis(dots, partner, 1).argmax(1)
    return best


def census_sobel(luma, cap=24):
    """Descriptors of `census-sobel` with a 7x7 window: 48 bits as one uint64, and the two gradients in int16."""
    height, width = luma.shape
    padded = np.pad(luma.astype(np.int16), 3, mode="edge")
    at = lambda dx, dy: padded[3 + dy : 3 + dy + height, 3 + dx : 3 + dx + width]
    bits = np.zeros((height, width), np.uint64)
    for dy in range(-3, 4):
        for dx in range(-3, 4):
            if dx or dy:
                bits = bits << np.uint64(1) | (at(dx, dy) < at(0, 0)).astype(np.uint64)
    gx = sum(k * (at(1, dy) - at(-1, dy)) for dy, k in ((-1, 1), (0, 2), (1, 1)))
    gy = sum(k * (at(dx, 1) - at(dx, -1)) for dx, k in ((-1, 1), (0, 2), (1, 1)))
    return bits, np.clip(gx, -cap, cap), np.clip(gy, -cap, cap)


def by_census_sobel(left, right, disparities):
    """The best disparity of each pixel by `census-sobel`; the lowest of equals."""
    (a, ax, ay), (b, bx, by) = census_sobel(left), census_sobel(right)
    x = np.arange(left.shape[1])
    best, least = np.zeros(left.shape, np.int64), np.full(left.shape, 1 << 20)
    for d in range(disparities):
        p = np.maximum(0, x - d)
        cost = 2 * np.bitwise_count(a ^ b[:, p]).astype(np.int64) + abs(ax - bx[:, p]) + abs(ay - by[:, p])
        better = cost < least
        best[better], least[better] = d, cost[better]
    return best


def wrong(best, pair, limit=3.0):
    """Per cent of the visible pixels that are off by more than `limit`."""
    seen = pair.visible
    return 100 * float((np.abs(best - pair.truth)[seen] > limit).mean())
