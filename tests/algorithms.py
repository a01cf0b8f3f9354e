"""docs/ALGORITHMS.md once more, in plain Python: following that page alone, to show that it is enough.

    python3 algorithms.py FOLDER           for each case in FOLDER (case.json, left.raw, right.raw), write the result of
                                           the n-th stage as NNN_STAGE.raw beside it
    python3 algorithms.py --example        print the worked example of the page
    python3 algorithms.py --vectors FILE   compute docs/vectors.json again, and fail at the first stage that differs

Needs nothing but Python 3.8. Raw files are little endian; tests/library/algorithms.rs writes the cases and compares the stages.
"""

import array
import functools
import json
import math
import os
import sys
import zlib

INVALID = -32768
# A census: columns to either side, rows from the centre, bits, bytes.
CENSUS = {
    "5x5": (2, range(-2, 3), 24, 5),
    "7x7": (3, range(-3, 4), 48, 7),
    "9x7": (4, range(-3, 4), 62, 8),
    "cs9x7": (4, range(-3, 0), 31, 4),
}
SAMPLES = {"gray8": ("B", 1), "gray16": ("H", 1), "rgba8": ("B", 4), "rgba16": ("H", 4)}
THREE = [(0, 1), (1, 0), (-1, 0)]
FOUR = THREE + [(0, -1)]
FIVE = THREE + [(1, 1), (-1, 1)]
EIGHT = FOUR + [(1, 1), (-1, -1), (-1, 1), (1, -1)]
SIXTEEN = EIGHT + [(1, 2), (-1, -2), (-1, 2), (1, -2), (2, 1), (-2, -1), (-2, 1), (2, -1)]
PATHS = {3: THREE, 4: FOUR, 5: FIVE, 8: EIGHT, 16: SIXTEEN}
FORWARD = [(0, 1), (1, 1), (-1, 1), (1, 0), (1, 2), (-1, 2), (2, 1), (-2, 1)]


def clamp(v, lo, hi):
    return min(max(v, lo), hi)


def level(v, u):
    return (v + u // 2) // u


def q(v):
    return (v + 8) >> 4


def unit_of(kind):
    return 257 if kind.endswith("16") else 1


def three(red, green, blue):
    return (red + 2 * green + blue) >> 2


def log(n):
    e = n.bit_length() - 1
    f = ((n << (31 - e)) >> 19) & 4095
    return 4096 * e + f + ((f * (4096 - f) * 11) >> 17)


@functools.lru_cache(maxsize=4096)
def smoothed_row(row):
    far = (row[0],) * 3 + row + (row[-1],) * 3
    return tuple(sum(w * n for w, n in zip((1, 6, 15, 20, 15, 6, 1), far[i:])) for i in range(len(row)))


def smoothed(table):
    rows = [smoothed_row(tuple(row)) for row in table]
    return zip(*(smoothed_row(column) for column in zip(*rows)))


def angle(l, p):
    return clamp((28900 - sum((a - 128) * (b - 128) for a, b in zip(l, p))) >> 7, 0, 225)


def network_of(case):
    """The layers of a case, or the network of the library."""
    if case.get("features") == "formula":
        return formula_network()
    if "features" in case:
        return [(layer["kind"], layer["relu"], layer["outputs"]) for layer in case["features"]]
    return library_network()


@functools.lru_cache(maxsize=1)
def library_network():
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../src/features/weights.bin"), "rb") as file:
        data = file.read()
    layers = [("convolution", True, 9)] + 4 * [("depthwise", False, 9), ("point", True, 64)]
    layers[-1] = ("point", False, 64)
    found, at = [], 0
    for kind, relu, each in layers:
        weights = array.array("b", data[at : at + 64 * each])
        words = array.array("i", data[at + 64 * each : at + 64 * each + 3 * 256])
        if sys.byteorder == "big":
            words.byteswap()
        at += 64 * each + 3 * 256
        outputs = [(weights[o * each : (o + 1) * each], words[o], words[64 + o], words[128 + o]) for o in range(64)]
        found.append((kind, relu, outputs))
    assert at == len(data)
    return found


def arc_tangent(r):
    for _ in range(4):
        r = r / (1.0 + math.sqrt(1.0 + r * r))
    total = 0.0
    for i in range(7, -1, -1):
        total = 1.0 / (2 * i + 1) - r * r * total
    return 16.0 * (r * total)


def sine_and_cosine(angle):
    sine, cosine = 1.0, 1.0
    for i in range(13, 0, -1):
        sine = 1.0 - angle * angle / (2 * i * (2 * i + 1)) * sine
        cosine = 1.0 - angle * angle / (2 * i * (2 * i - 1)) * cosine
    return angle * sine, cosine


def bent(lens, x, y):
    """Where a ray through (x, y) meets the sensor, both at a distance of 1; None where it does not."""
    xx, yy, xy = x * x, y * y, x * y
    q = xx + yy
    if "fisheye" in lens:
        k1, k2, k3, k4 = lens["fisheye"]
        r = math.sqrt(q)
        angle = arc_tangent(r)
        t = angle * angle
        scale = 1.0 if r == 0.0 else angle * (1.0 + (((k4 * t + k3) * t + k2) * t + k1) * t) / r
        return x * scale, y * scale
    if "double_sphere" in lens or "extended_unified" in lens:
        if "double_sphere" in lens:
            xi, alpha = lens["double_sphere"]
            z = xi * math.sqrt(q + 1.0) + 1.0
            w = alpha * math.sqrt(q + z * z) + (1.0 - alpha) * z
        else:
            alpha, beta = lens["extended_unified"]
            w = alpha * math.sqrt(beta * q + 1.0) + (1.0 - alpha)
        return (x / w, y / w) if w > 0.0 else None
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tau_x, tau_y = lens["pinhole"]
    radial = (1.0 + ((k3 * q + k2) * q + k1) * q) / (1.0 + ((k6 * q + k5) * q + k4) * q)
    column = x * radial + 2.0 * p1 * xy + p2 * (q + 2.0 * xx) + s1 * q + s2 * (q * q)
    row = y * radial + p1 * (q + 2.0 * yy) + 2.0 * p2 * xy + s3 * q + s4 * (q * q)
    if tau_x == 0.0 and tau_y == 0.0:
        return column, row
    (sin_x, cos_x), (sin_y, cos_y) = sine_and_cosine(tau_x), sine_and_cosine(tau_y)
    w = sin_y * column - cos_y * sin_x * row + cos_y * cos_x
    return (cos_x * column / w, (cos_y * row - sin_x * sin_y * column) / w) if w > 0.0 else None


class Chain:
    """The stages by their names. Images are [y][x], volumes [y][x][d]."""

    def __init__(self, case):
        self.width, self.height = case["width"], case["height"]
        self.smallest, self.count = case["min_disparity"], case["disparities"]
        self.case = case
        self.contents = None  # of the left and of the right view, where not all pixels have content
        self.cap, self.block = case["prefilter_cap"], case["block"]
        self.radius = (self.block - 1) // 2
        self.census_bits, census_bytes = CENSUS[case["census"]][2:]
        self.census_bytes = census_bytes if "census" in case["cost"] else 0
        self.largest_total = self.block**2 * self.largest_pixel_cost()
        self.narrowing = 0 if case["cost"] == "ncc" else max(0, self.largest_total.bit_length() - 20)

        self.rules = case["opencv_rules"] == "on"

    def inside(self, x):
        return 0 <= x <= self.width - 1

    def points_inside(self, x, v):
        return self.inside(x - q(v))

    def at(self, image, x, y):
        return image[clamp(y, 0, self.height - 1)][clamp(x, 0, self.width - 1)]

    def over_pixels(self, formula):
        return [[formula(x, y) for x in range(self.width)] for y in range(self.height)]

    def positions(self, lens):
        """Where the pixels of the rectified image come from, in 1/256 px."""
        p, r, m = lens["projection"], lens["rotation"], lens["matrix"]
        a = [p[i - i % 3] * r[i % 3] + p[i - i % 3 + 1] * r[i % 3 + 3] + p[i - i % 3 + 2] * r[i % 3 + 6] for i in range(9)]
        pairs = ((4, 8, 5, 7), (2, 7, 1, 8), (1, 5, 2, 4), (5, 6, 3, 8), (0, 8, 2, 6), (2, 3, 0, 5))
        pairs += ((3, 7, 4, 6), (1, 6, 0, 7), (0, 4, 1, 3))
        cofactors = [a[i] * a[j] - a[k] * a[n] for i, j, k, n in pairs]
        determinant = a[0] * cofactors[0] + a[1] * cofactors[3] + a[2] * cofactors[6]
        b = [cofactor / determinant for cofactor in cofactors]

        def of(u, v):
            x, y, w = (b[i] * u + b[i + 1] * v + b[i + 2] for i in (0, 3, 6))
            ray = bent(lens, x / w, y / w) if w > 0.0 else None
            if ray is None:
                return [-512, -512]
            places = ((m[0] * ray[0] + m[2], self.width), (m[4] * ray[1] + m[5], self.height))
            return [clamp(math.floor(256.0 * place + 0.5), -512, 256 * side) for place, side in places]

        return self.over_pixels(lambda x, y: of(float(x), float(y)))

    def rectify(self, lens, kind, samples):
        count = SAMPLES[kind][1]

        def at(x, y, i):
            inside = self.inside(x) and 0 <= y < self.height
            return samples[(y * self.width + x) * count + i] if inside else 0

        def blend(px, py, i):
            x, y, a, b = px >> 8, py >> 8, px & 255, py & 255
            above = (256 - a) * at(x, y, i) + a * at(x + 1, y, i)
            below = (256 - a) * at(x, y + 1, i) + a * at(x + 1, y + 1, i)
            return ((256 - b) * above + b * below + 32768) >> 16

        return [blend(*place, i) for row in self.positions(lens) for place in row for i in range(count)]

    def content(self, mask, lens):
        """Which pixels of a side have content."""

        def given(x, y):
            return self.inside(x) and 0 <= y < self.height and (mask is None or mask[y * self.width + x] != 0)

        if lens is None:
            return self.over_pixels(given)
        positions = self.positions(lens)

        def rectified(x, y):
            px, py = positions[y][x]
            columns = {px >> 8, (px + 255) >> 8}
            return all(given(i, j) for i in columns for j in {py >> 8, (py + 255) >> 8})

        return self.over_pixels(rectified)

    def in_rectangle(self, x, y):
        """Where OpenCV gives disparities."""
        w, r, m = self.width, self.radius, self.smallest
        if self.case["method"] != "bm":
            return max(0, m + self.count) <= x <= w - 1 + min(0, m)
        return max(0, m + self.count - 1) + r <= x <= w - 1 - max(r, -m) and r <= y <= self.height - 1 - r

    def halved_content(self, content):
        four = [(0, 0), (1, 0), (0, 1), (1, 1)]
        half = Chain(dict(self.case, width=(self.width + 1) // 2, height=(self.height + 1) // 2))
        return half.over_pixels(lambda x, y: all(self.at(content, 2 * x + i, 2 * y + j) for i, j in four))

    def validity(self, disparities, side):
        """The map of the left (0) or of the right view (1)."""
        if self.contents is None:
            return disparities
        here, there = self.contents[side], self.contents[1 - side]

        def stays(x, y):
            place = 16 * x + (disparities[y][x] if side else -disparities[y][x])
            seen = {math.floor(place / 16), math.ceil(place / 16)}
            return here[y][x] and all(self.at(there, i, y) for i in seen)

        return self.over_pixels(lambda x, y: disparities[y][x] if stays(x, y) else INVALID)

    def deep_gray(self, kind, samples):
        """The channels at the depth of the samples."""

        def sample(i):
            return self.over_pixels(lambda x, y: samples[(y * self.width + x) * SAMPLES[kind][1] + i])

        if kind.startswith("gray"):
            return [sample(0)] * (3 if self.case["color_cost"] == "on" else 1)
        colours = [sample(i) for i in (0, 1, 2)]
        return colours if self.case["color_cost"] == "on" else [self.luma(kind, samples)]

    def luma(self, kind, samples):
        def value(x, y):
            p = (y * self.width + x) * SAMPLES[kind][1]
            if kind.startswith("gray"):
                return samples[p]
            return (9798 * samples[p] + 19235 * samples[p + 1] + 3735 * samples[p + 2] + 16384) >> 15

        return self.over_pixels(value)

    def gray(self, kind, samples):
        luma = self.luma(kind, samples)
        return self.over_pixels(lambda x, y: level(luma[y][x], unit_of(kind)))

    def window_sums(self, image, side):
        reach = range(-(side // 2), side // 2 + 1)
        rows = self.over_pixels(lambda x, y: sum(self.at(image, x + i, y) for i in reach))
        return self.over_pixels(lambda x, y: sum(self.at(rows, x, y + j) for j in reach))

    def derivatives(self, image, u, x, y, rules_border=False):
        """Gx and Gy; Gx alone where `opencv_rules` may change it at the border."""

        bottom = self.height - 1

        def at(i, j):
            return self.at(image, x + i, y + j)

        def across(i, j):
            row = abs(y + j)
            return self.at(image, x + i, 2 * bottom - row if row > bottom else row)

        if rules_border and self.rules:
            if x in (0, self.width - 1) or (y == bottom and self.height % 2 == 1):
                return 0, 0
            return level(sum(w * (across(1, j) - across(-1, j)) for j, w in ((-1, 1), (0, 2), (1, 1))), u), 0
        gx = at(1, -1) - at(-1, -1) + 2 * (at(1, 0) - at(-1, 0)) + at(1, 1) - at(-1, 1)
        gy = at(-1, 1) - at(-1, -1) + 2 * (at(0, 1) - at(0, -1)) + at(1, 1) - at(1, -1)
        return level(gx, u), level(gy, u)

    def clipped(self, v):
        return clamp(v, -self.cap, self.cap) + self.cap

    def prefilter(self, g, u):
        kind, w = self.case["prefilter"], self.case["prefilter_window"]
        n = w * w
        sums = self.window_sums(g, w) if kind == "normalized" else None

        def value(x, y):
            if kind == "none":
                return g[y][x]
            if kind == "normalized":
                beside = sum(self.at(g, x + i, y + j) for i, j in ((-1, 0), (1, 0), (0, -1), (0, 1)))
                t = 4 * g[y][x] + beside
                if self.rules:
                    e = n // 8
                    k = (1024 + e) // (2 * e)
                    return self.clipped((e * t - sums[y][x]) * k // (1024 * u))
                return self.clipped((n * t - 8 * sums[y][x]) // (2 * n * u))
            gx, gy = self.derivatives(g, u, x, y, kind == "xsobel")
            return self.clipped(gx) if kind == "xsobel" else min(math.isqrt(gx * gx + gy * gy), 2 * self.cap)

        return self.over_pixels(value)

    def census(self, f, x, y):
        """The bytes of the census string."""
        side, rows = CENSUS[self.case["census"]][:2]
        symmetric = self.case["census"] == "cs9x7"

        def bit(dx, dy):
            other = self.at(f, x - dx, y - dy) if symmetric else f[y][x]
            return 1 if self.at(f, x + dx, y + dy) < other else 0

        found = [sum(bit(dx, dy) << (4 + dx) for dx in range(-side, min(side, 3) + 1)) for dy in rows]
        if side == 4:
            last = sum(bit(4, dy) << p for p, dy in enumerate(rows))
            found.append(last + (sum(bit(dx, 0) << (7 + dx) for dx in range(-4, 0)) if symmetric else 0))
        return found

    def feature_statistics(self, f, u):
        """The mean and the deviation."""
        deep = [v if u == 257 else 256 * v for row in f for v in row]
        shift = 0
        while len(deep) >> shift > 8192:
            shift += 1
        counts = [0] * 1024
        for v in deep:
            counts[v >> 6] += 1
        some = [(n + ((1 << shift) // 2)) >> shift for n in counts]
        number, total = sum(some), sum(n * k for k, n in enumerate(some))
        centre, mean = total // number, 64 * total // number
        spread = sum(n * (k - centre) ** 2 for k, n in enumerate(some))
        variance = 256 * spread // number - ((mean - 64 * centre) ** 2 >> 4)
        return [mean + (32 if u == 257 else 0), max(1, math.isqrt(variance))]

    def features(self, f, u, statistics):
        """The bytes of each pixel; a layer is (kind, relu, and for each output its weights, bias, multiplier and shift)."""
        mean, deviation = statistics

        def of_input(x, y):
            a = (f[y][x] if u == 257 else 256 * f[y][x]) - mean
            size = min(127, (16 * abs(a) + deviation) // (2 * deviation))
            return -size if a < 0 else size

        values, layers = [self.over_pixels(of_input)], network_of(self.case)
        square = [(i, j) for j in (-1, 0, 1) for i in (-1, 0, 1)]
        for n, (kind, relu, outputs) in enumerate(layers):
            last = n == len(layers) - 1
            low, high = (-2047, 2047) if last else (0, 127) if relu else (-127, 127)

            def output(o, weights, bias, multiplier, shift, values=values, kind=kind, low=low, high=high):
                channels = [values[o]] if kind == "depthwise" else values
                taps = [(v, i, j) for v in channels for i, j in (((0, 0),) if kind == "point" else square)]
                taps = [(w, v, i, j) for w, (v, i, j) in zip(weights, taps) if w != 0]

                def value(x, y):
                    acc = bias + sum(w * self.at(v, x + i, y + j) for w, v, i, j in taps)
                    return clamp((acc * multiplier + (1 << (shift - 1))) >> shift, low, high)

                return self.over_pixels(value)

            values = [output(o, *numbers) for o, numbers in enumerate(outputs)]

        def bytes_of(x, y):
            v = [channel[y][x] for channel in values]
            total = sum(a * a for a in v)
            length = math.isqrt(total - 1) + 1 if total > 0 else 0
            sizes = [min(127, (340 * abs(a) + length) // (2 * length)) if length > 0 else 0 for a in v]
            return [128 + (-size if a < 0 else size) for a, size in zip(v, sizes)]

        return self.over_pixels(bytes_of)

    def descriptors(self, channels, u):
        cost, n = self.case["cost"], self.block**2

        def of_channel(f, sums, x, y):
            v = level(f[y][x], u)
            if cost in ("sad", "ssd", "ncc", "mi"):
                return [v]
            if cost == "zsad":
                z = (2 * (n * f[y][x] - sums[y][x]) + n * u) // (2 * n * u)
                return [clamp(z, -127, 127) + 127]
            if cost in ("bt", "bt-gray"):
                a, b = ((v + level(self.at(f, x + i, y), u)) // 2 for i in (-1, 1))
                return [v, min(v, a, b), max(v, a, b)]
            found = self.census(f, x, y) if self.census_bytes else []
            if cost in ("sad-xy", "census-sobel", "learned-census"):
                found += [self.clipped(g) for g in self.derivatives(f, u, x, y)]
            if cost == "ad-census":
                found.append(v)
            return found

        sums = [self.window_sums(f, self.block) if cost == "zsad" else None for f in channels]
        return self.over_pixels(lambda x, y: [v for f, s in zip(channels, sums) for v in of_channel(f, s, x, y)])

    def mix(self, a, b):
        return min(255, (self.case["ad_weight"] * a + self.case["census_weight"] * b + 8) >> 4)

    def blend(self, a, b):
        return min(255, (self.case.get("learned_weight", 0) * a + self.case["census_weight"] * b + 32) >> 6)

    def largest_pixel_cost(self):
        v = 255 if self.case["prefilter"] == "none" else 2 * self.cap
        return {
            "sad": v,
            "ssd": v * v,
            "ncc": v * v,
            "mi": 255,
            "zsad": min(2 * v, 254),
            "bt": v,
            "bt-gray": min(v + 63, 255),
            "sad-xy": 4 * self.cap,
            "census": self.census_bits,
            "census-sobel": 2 * self.census_bits + 4 * self.cap,
            "ad-census": max(1, self.mix(v, self.census_bits)),
            "learned": 225,
            "learned-census": max(1, self.blend(225, 2 * self.census_bits + 4 * self.cap)),
        }[self.case["cost"]]

    def pixel_cost(self, l, p):
        cost, i = self.case["cost"], self.census_bytes
        if cost == "mi":
            return self.table[l[0]][p[0]]
        if cost == "learned":
            return angle(l, p)
        if cost in ("bt", "bt-gray"):

            def between(i):
                def outside(v, low, high):
                    return max(0, low - v, v - high)

                return min(outside(l[i], p[i + 1], p[i + 2]), outside(p[i], l[i + 1], l[i + 2]))

            if cost == "bt-gray":
                return min(255, between(0) + (between(3) >> 2))
            return three(*map(between, (0, 3, 6))) if self.case["color_cost"] == "on" else between(0)
        difference = [abs(a - b) for a, b in zip(l, p)]
        bits = sum(bin(a ^ b).count("1") for a, b in zip(l[:i], p[:i]))
        if cost == "sad":
            return three(*difference) if self.case["color_cost"] == "on" else difference[0]
        if cost == "ssd":
            return difference[0] ** 2
        if cost == "ncc":
            return l[0] * p[0]
        if cost == "zsad":
            return difference[0]
        if cost == "sad-xy":
            return difference[0] + difference[1]
        if cost == "census":
            return bits
        if cost in ("census-sobel", "learned-census"):
            both = 2 * bits + difference[i] + difference[i + 1]
            return both if cost == "census-sobel" else self.blend(angle(l[i + 2 :], p[i + 2 :]), both)
        return self.mix(difference[i], bits)

    def halve(self, image):
        half = Chain(dict(self.case, width=(self.width + 1) // 2, height=(self.height + 1) // 2))

        def mean(x, y):
            return [(sum(self.at(image, 2 * x + i, 2 * y + j)[0] for i in (0, 1) for j in (0, 1)) + 2) >> 2]

        return half.over_pixels(mean)

    def mi_histogram(self, left, right, before, halved):
        counts = [[0] * 256 for _ in range(256)]
        for y in range(self.height if before else 0):
            for x in range(self.width):
                v = before[y >> halved][x >> halved]
                seen = x - q(v << halved)
                if v != INVALID and self.inside(seen):
                    counts[left[y][x][0]][right[y][seen][0]] += 1
        return counts

    def mi_table(self, counts):
        pixels = self.width * self.height
        narrowing = max(0, pixels.bit_length() - 20)
        prior = ((pixels >> narrowing) >> 8) + 1
        joint = smoothed([[n >> narrowing for n in row] for row in counts])
        joint = [[n + prior for n in row] for row in joint]
        sums = [sum(row) for row in joint], [sum(column) for column in zip(*joint)]
        joint = [[(n + 2048) >> 12 for n in row] for row in smoothed([[log(n) for n in row] for row in joint])]
        lefts, rights = ([(n + 32) >> 6 for n in smoothed_row(tuple(log(n) for n in values))] for values in sums)
        shared = [[n - a - b for n, b in zip(row, rights)] for row, a in zip(joint, lefts)]
        least, most = min(map(min, shared)), max(map(max, shared))
        span = most - least
        if span == 0:
            return [[abs(l - r) for r in range(256)] for l in range(256)]
        return [[(255 * (most - n) + span // 2) // span for n in row] for row in shared]

    def last_table(self, left, right):
        """The rounds of mutual information: their stages; returns the table of the last round."""
        most = max(h for h in range(5) if h == 0 or min(self.width, self.height) >> h >= 16)
        pyramid = [(self, left, right)]
        for _ in range(most):
            chain, left, right = pyramid[-1]
            half = Chain(dict(chain.case, width=(chain.width + 1) // 2, height=(chain.height + 1) // 2))
            if chain.contents is not None:
                half.contents = [chain.halved_content(content) for content in chain.contents]
            pyramid.append((half, chain.halve(left), chain.halve(right)))
            yield "halve", [("B", pyramid[-1][1]), ("B", pyramid[-1][2])]
        before, last = None, self.smallest + self.count - 1
        rounds = [most] * 2 + list(range(most, -1, -1))
        for i, h in enumerate(rounds):
            size, left, right = pyramid[h]
            smallest, largest = self.smallest >> h, -(-last >> h)
            changed = dict(disparities=largest - smallest + 1, lr_check=1, smoothness_edge="off", passes=1)
            chain = Chain(dict(size.case, min_disparity=smallest, **changed))
            chain.contents = size.contents
            counts = chain.mi_histogram(left, right, before, rounds[i - 1] - h if i > 0 else 0)
            yield "mi_histogram", [("I", counts)]
            chain.table = chain.mi_table(counts)
            yield "mi_table", [("B", chain.table)]
            if i + 1 < len(rounds):
                view, other, _ = yield from chain.winner_stages(left, right, None, None)
                other = yield from chain.valid(other, 1)
                view = yield from chain.valid(view, 0)
                before = chain.lr_check(view, other)
                yield "lr_check", [("h", before)]
        return chain.table

    def cost_columns(self, left, right):
        columns = range(-self.radius, self.width + self.radius)

        def costs(x, y):
            seen = [self.at(right, x - (self.smallest + d), y) for d in range(self.count)]
            return [self.pixel_cost(self.at(left, x, y), p) for p in seen]

        # Both images are continued by the same rows, so the pixel costs are, too.
        rows = [[costs(x, y) for x in columns] for y in range(self.height)]

        def column(c, y):
            block = [rows[clamp(y + j, 0, self.height - 1)][c] for j in range(-self.radius, self.radius + 1)]
            return [sum(values) for values in zip(*block)]

        return [[column(c, y) for c in range(len(columns))] for y in range(self.height)]

    def block_sums(self, columns):
        def sums(x, y):
            return [sum(values) >> self.narrowing for values in zip(*columns[y][x : x + 2 * self.radius + 1])]

        return self.over_pixels(sums)

    def scale(self):
        largest = self.largest_total >> self.narrowing
        eighths = dict.fromkeys(("census-sobel", "learned", "learned-census"), 128 * self.largest_pixel_cost())
        tops = dict(eighths, mi=64 * 1024)
        top = tops.get(self.case["cost"], 59 * 1550)
        return (top * 2**14 + largest // 2) // largest

    def block_statistics(self, plane, columns):
        reach = range(-self.radius, self.radius + 1)

        def of_block(x, y):
            values = [self.at(plane, x + i, y + j)[0] for i in reach for j in reach]
            return [sum(values), math.isqrt(len(values) * sum(v * v for v in values) - sum(values) ** 2)]

        return [[of_block(x, y) for x in columns] for y in range(self.height)]

    def correlation_costs(self, sums, left, right):
        n, first = self.block**2, self.smallest + self.count - 1  # right blocks begin at column -first

        def cost(x, y, d):
            (s, a), (other_s, other_a) = left[y][x], right[y][x - (self.smallest + d) + first]
            c = n * sums[y][x][d] - s * other_s
            part = min(4096, 4096 * abs(c) // (a * other_a)) if a * other_a > 0 else 0
            return 4096 - part if c >= 0 else 4096 + part

        return self.over_pixels(lambda x, y: [cost(x, y, d) for d in range(self.count)])

    def matching_cost(self, sums):
        scale = self.scale()
        return [[[(s * scale + 2**23) >> 24 for s in pixel] for pixel in row] for row in sums]

    def penalties(self, g):
        p1, p2, step = self.case["p1"], self.case["p2"], self.case["p2_step"]

        def of_step(x, y, dx, dy):
            inside = self.inside(x - dx) and 0 <= y - dy < self.height
            delta = abs(g[y][x] - g[y - dy][x - dx]) if inside else 0
            large = p2
            if self.case["adaptive_p2"] == "on":
                large = min(p2, max(step * p2 // max(delta, step), p1 + p1 // 2))
            if self.case["adaptive_p1"] == "on":
                return [large, min(p1, max(8, 3 * p1 // max(delta, 3)))]
            return [large]

        directions = FORWARD[: 8 if self.case["paths"] == 16 else 4]
        return self.over_pixels(lambda x, y: [v for dx, dy in directions for v in of_step(x, y, dx, dy)])

    def of_step(self, penalties, x, y, dx, dy):
        """P1 and P2 of the step into (x, y)."""
        p1, p2 = self.case["p1"], self.case["p2"]
        if penalties is None:
            return p1, p2
        if (dx, dy) in FORWARD:
            entries, k = penalties[y][x], FORWARD.index((dx, dy))
        else:
            entries, k = penalties[y - dy][x - dx], FORWARD.index((-dx, -dy))
        return (entries[2 * k + 1], entries[2 * k]) if self.case["adaptive_p1"] == "on" else (p1, entries[k])

    def path_costs(self, cost, penalties, dx, dy):
        """L of one direction. Pixels are visited so that the pixel before comes first."""
        path = self.over_pixels(lambda x, y: None)
        for y in range(self.height) if dy >= 0 else reversed(range(self.height)):
            for x in range(self.width) if dx >= 0 else reversed(range(self.width)):
                smooth = [0] * self.count
                if self.inside(x - dx) and 0 <= y - dy < self.height:
                    before = path[y - dy][x - dx]
                    m, (p1, p2) = min(before), self.of_step(penalties, x, y, dx, dy)
                    for d, stay in enumerate(before):
                        steps = [before[e] + p1 for e in (d - 1, d + 1) if 0 <= e < self.count]
                        smooth[d] = min([stay, m + p2] + steps) - m
                path[y][x] = [c + t for c, t in zip(cost[y][x], smooth)]
        return path

    def sgm_aggregate(self, cost, penalties):
        paths = [self.path_costs(cost, penalties, dx, dy) for dx, dy in PATHS[self.case["paths"]]]
        return self.over_pixels(lambda x, y: [sum(values) for values in zip(*(path[y][x] for path in paths))])

    def second_cost(self, cost, sums):
        n = self.case["paths"]
        mean = lambda x, y: [(s + n * c + n) // (2 * n) for s, c in zip(sums[y][x], cost[y][x])]
        return self.over_pixels(mean)

    def coarse_cost(self, cost):
        """The data terms of all levels but the first."""
        levels = [cost]
        while len(levels) < self.case["bp_levels"] and (len(levels[-1]) > 1 or len(levels[-1][0]) > 1):
            finer = levels[-1]
            height, width = len(finer), len(finer[0])

            def terms(x, y):
                lines = [finer[j] for j in (2 * y, 2 * y + 1) if j < height]
                sums = [sum(v) for v in zip(*(line[i] for line in lines for i in (2 * x, 2 * x + 1) if i < width))]
                return [min(2047, v - min(sums)) for v in sums]

            levels.append([[terms(x, y) for x in range((width + 1) // 2)] for y in range((height + 1) // 2)])
        return levels[1:]

    def smoothness(self, k, halved):
        a, b = self.case["smoothness_weight"] >> halved, self.case["smoothness_truncation"] >> halved
        kind = self.case["smoothness"]
        if kind == "potts":
            return b if k > 0 else 0
        return min(a * k if kind == "linear" else a * k * k, b)

    def message(self, belief, received, f, halved):
        h = [((f * v) >> 4) - m for v, m in zip(belief, received)]
        most = self.case["smoothness_truncation"] >> halved
        values = [min(v - min(h), most) for v in h]  # V is at most `most`
        sent = values[:]
        for e, value in enumerate(values):
            for way in (-1, 1):
                k = 1
                while 0 <= e + way * k < self.count and value + self.smoothness(k, halved) < most:
                    d = e + way * k
                    sent[d] = min(sent[d], value + self.smoothness(k, halved))
                    k += 1
        return sent

    def messages(self, levels, g):
        """What the pixels of each level have received, from the coarsest to the finest: lists [from][y][x][d]."""
        rounds, share = self.case["bp_iterations"], self.case["bp_reweighting"]
        ways = ((-1, 0), (1, 0), (0, -1), (0, 1))
        found = []
        for k in reversed(range(len(levels))):
            terms = levels[k]
            height, width = len(terms), len(terms[0])
            if found:
                here = [[[coarse[y >> 1][x >> 1] for x in range(width)] for y in range(height)] for coarse in found[-1]]
            else:
                here = [[[[0] * self.count for _ in range(width)] for _ in range(height)] for _ in ways]
            for i in range(rounds):
                f = share
                if k == 0 and i >= rounds >> 1:
                    since = i - (rounds >> 1)
                    f = share + (16 - share) * (since + 1) // ((rounds >> 2) + 1) if since < rounds >> 2 else 16
                for x, y in ((x, y) for y in range(height) for x in range(width) if (x + y + i) % 2 == 0):
                    belief = [sum(v) for v in zip(terms[y][x], *(volume[y][x] for volume in here))]
                    for w, (dx, dy) in enumerate(ways):
                        u, v = x + dx, y + dy
                        if not (0 <= u < width and 0 <= v < height):
                            continue
                        edge = self.case["smoothness_edge"]
                        halved = int(k == 0 and edge != "off" and abs(g[y][x] - g[v][u]) >= edge)
                        here[w ^ 1][v][u] = self.message(belief, here[w][y][x], f, halved)
            found.append(here)
        return found

    def winner(self, cost):
        last, ratio = self.count - 1, self.case["uniqueness"]

        as_stereo_bm = self.rules and self.case["method"] == "bm"

        def best_of(s):
            return max(d for d in range(self.count) if s[d] == min(s)) if as_stereo_bm else s.index(min(s))

        def left(x, y):
            s = cost[y][x]
            best = best_of(s)
            rivals = [s[d] for d in range(self.count) if abs(d - best) > 1]
            if as_stereo_bm:
                if ratio > 0 and any(a <= s[best] + s[best] * ratio // 100 for a in rivals):
                    return INVALID
            elif self.rules and ratio > 0 and any(a * (100 - ratio) < s[best] * 100 for a in rivals):
                return INVALID
            elif not self.rules and ratio > 0 and not all(a * (100 - ratio) > s[best] * 100 for a in rivals):
                return INVALID
            v = 16 * (self.smallest + best)
            if self.case["subpixel"] != "off" and 0 < best < last:
                a, b, c = s[best - 1 : best + 2]
                if as_stereo_bm:
                    z = 128 * abs(a - c) // max(1, max(a, c) - b)
                    v += (z + 15) // 16 if a > c else -(z // 16)
                    return v if self.points_inside(x, v) else INVALID
                if self.rules:
                    k = max(1, a + c - 2 * b)
                    z = 16 * (a - c) + k
                    v += z // (2 * k) if z >= 0 else -(-z // (2 * k))
                    return v if self.points_inside(x, v) else INVALID
                k = max(a, c) - b if self.case["subpixel"] == "equiangular" else a + c - 2 * b
                v += (16 * (a - c) + k - 1) // (2 * k)
            return v if self.points_inside(x, v) else INVALID

        def right(x, y):
            least, value = None, INVALID
            for d in range(self.count):
                seen_from = x + self.smallest + d
                if self.inside(seen_from) and (least is None or cost[y][seen_from][d] < least):
                    least, value = cost[y][seen_from][d], 16 * (self.smallest + d)
            return value

        def margin(x, y):
            s = cost[y][x]
            best = best_of(s)
            rivals = [s[d] for d in range(self.count) if abs(d - best) > 1]
            if not rivals:
                return 255
            rival = min(rivals)
            return 255 * (rival - s[best]) // rival if rival > 0 else 0

        return self.over_pixels(left), self.over_pixels(right), self.over_pixels(margin)

    def energy(self, labels, g):
        """The data terms of all labels in sum, and the smoothness of all neighbours in sum."""
        data, smooth = 0, 0
        edge = self.case["smoothness_edge"]
        for y in range(self.height):
            for x in range(self.width):
                data += self.terms[y][x][labels[y][x]]
                for u, v in ((x - 1, y), (x, y - 1)):
                    if u >= 0 and v >= 0:
                        halved = int(edge != "off" and abs(g[y][x] - g[v][u]) >= edge)
                        k = abs(labels[y][x] - labels[v][u])
                        smooth += self.smoothness(k, halved)
        return [data, smooth]

    def texture(self, disparities, g):
        least = self.case["texture"]
        if least == 0:
            return disparities
        e = self.over_pixels(lambda x, y: min(abs(self.derivatives(g, 1, x, y, True)[0]), self.case["prefilter_cap"]))
        block = range(-self.radius, self.radius + 1)

        def kept(x, y):
            t = sum(self.at(e, x + i, y + j) for j in block for i in block)
            return disparities[y][x] if t >= least else INVALID

        return self.over_pixels(kept)

    def lr_check(self, left, right):
        if self.case["lr_check"] == "off":
            return left

        def checked(x, y):
            v = left[y][x]
            if v == INVALID or not self.points_inside(x, v):
                return INVALID
            w = right[y][x - q(v)]
            return v if w != INVALID and abs(w // 16 - q(v)) <= self.case["lr_check"] else INVALID

        return self.over_pixels(checked)

    def speckle(self, disparities):
        window, step = self.case["speckle_window"], 16 * self.case["speckle_range"]
        result = [row[:] for row in disparities]
        done = set()
        for y in range(self.height):
            for x in range(self.width):
                if disparities[y][x] == INVALID or (x, y) in done:
                    continue
                region, waiting = {(x, y)}, [(x, y)]
                while waiting:
                    i, j = waiting.pop()
                    for k, l in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)):
                        if self.inside(k) and 0 <= l < self.height and (k, l) not in region:
                            v, w = disparities[j][i], disparities[l][k]
                            if w != INVALID and abs(v - w) <= step:
                                region.add((k, l))
                                waiting.append((k, l))
                done |= region
                if len(region) <= window:
                    for i, j in region:
                        result[j][i] = INVALID
        return result

    def median(self, disparities):
        if self.case["median"] == "off":
            return disparities
        side = self.case["median"]
        steps = range(-(side // 2), side // 2 + 1)

        def middle(x, y):
            v = sorted(self.at(disparities, x + i, y + j) for j in steps for i in steps)[side * side // 2]
            return v if self.points_inside(x, v) else INVALID

        return self.over_pixels(middle)

    def gray_weight(self, difference):
        sigma = self.case["weighted_median_sigma"]
        decay = (65536 + sigma // 2) // sigma
        t = (difference * decay) >> 8
        return (64 * (512 - t % 256)) >> (t // 256)

    def weighted_middle(self, pairs):
        """The smallest value up to which half of the weight lies; pairs are (value, weight)."""
        total, reached = sum(w for _, w in pairs), 0
        for value, w in sorted(pairs):
            reached += w
            if 2 * reached >= total:
                return value

    def weighted_median(self, disparities, gray):
        if self.case["weighted_median"] == "off":
            return disparities
        spacing = (self.case["weighted_median"] + 1) // 2
        steps = [spacing * i for i in (-2, -1, 0, 1, 2)]

        def middle(x, y):
            if disparities[y][x] == INVALID:
                return INVALID
            around = [(x + i, y + j) for j in steps for i in steps if self.inside(x + i) and 0 <= y + j < self.height]
            valid = [(disparities[v][u], self.gray_weight(abs(gray[v][u] - gray[y][x]))) for u, v in around]
            return self.weighted_middle([pair for pair in valid if pair[0] != INVALID])

        return self.over_pixels(middle)

    def wls(self, disparities, gray):
        if self.case["wls"] == "off":
            return disparities
        strength, sigma = map(float, self.case["wls"].split(","))
        term = total = 1.0
        for k in range(1, 201):
            term = term * (1.0 / sigma) / k
            total += term
        decay = 1.0 / total
        bits = 31 - (16 * self.count - 1).bit_length()
        values = self.over_pixels(lambda x, y: (0, 0))
        for x, y in ((x, y) for y in range(self.height) for x in range(self.width)):
            if disparities[y][x] != INVALID:
                values[y][x] = ((disparities[y][x] - 16 * self.smallest) << bits, 2**30)

        def solve(line, coupling):
            def blend(a, b, share):
                return tuple((u * share + v * (65536 - share) + 32768) >> 16 for u, v in zip(a, b))

            mean, weight, means, shares = (0, 0), 64, [], []
            for i, (x, y) in enumerate(line):
                mean = blend(values[y][x], mean, 2**22 // weight)
                means.append(mean)
                c = 0
                if i + 1 < len(line):
                    u, v = line[i + 1]
                    c = coupling[abs(gray[y][x] - gray[v][u])]
                shares.append(65536 * weight // (weight + c))
                weight = 64 + (((65536 - shares[-1]) * weight) >> 16)
            solution = (0, 0)
            for (x, y), mean, share in reversed(list(zip(line, means, shares))):
                solution = values[y][x] = blend(mean, solution, share)

        for divisor in (1.0, 4.0, 16.0):
            coupling, w = [], 1.0
            for _ in range(256):
                coupling.append(max(1, math.floor(64.0 * strength / divisor * w + 0.5)))
                w *= decay
            for y in range(self.height):
                solve([(x, y) for x in range(self.width)], coupling)
            for x in range(self.width):
                solve([(x, y) for y in range(self.height)], coupling)

        def quotient(x, y):
            product, confidence = values[y][x]
            if confidence < 2**14:
                return INVALID
            above = ((product << (31 - bits)) // confidence + 1) >> 1
            return 16 * self.smallest + min(above, 16 * (self.count - 1))

        return self.over_pixels(quotient)

    def confidence(self, disparities, margins):
        return self.over_pixels(lambda x, y: 0 if disparities[y][x] == INVALID else max(margins[y][x], 1))

    def depth(self, disparities):
        focal, baseline, doffs = map(float, self.case["depth"].split(","))
        product, offset = math.floor(focal * baseline * 4096000000.0 + 0.5), math.floor(doffs * 4096.0 + 0.5)

        def of(x, y):
            divisor = 256 * disparities[y][x] + offset
            if disparities[y][x] == INVALID or divisor <= 0 or product // divisor >= 2**32:
                return 0
            return product // divisor

        return self.over_pixels(of)

    def on_ray(self, disparities, x, y, direction, count):
        """The first valid pixels in a direction, at most `count`."""
        found, i, j = [], x + direction[0], y + direction[1]
        while self.inside(i) and 0 <= j < self.height and len(found) < count:
            if disparities[j][i] != INVALID:
                found.append((i, j))
            i, j = i + direction[0], j + direction[1]
        return found

    def nearest(self, disparities, x, y, directions):
        found = [pixel for direction in directions for pixel in self.on_ray(disparities, x, y, direction, 1)]
        return sorted(disparities[j][i] for i, j in found)

    def beside(self, disparities, x, y):
        """The smaller of the medians of three on either side of the row, or the only one, led on by the slope there."""
        medians = []
        for direction in [(-1, 0), (1, 0)]:
            found = self.on_ray(disparities, x, y, direction, 3)
            values = sorted(disparities[j][i] for i, j in found)
            medians += [(values[(len(values) - 1) // 2], direction[0], found[0][0])] if values else []
        if len(medians) == 2:
            return min(medians)[0]
        value, a, end = medians[0]
        led = (self.slope(disparities, a, end, y) * (abs(x - end) + 1)) >> 3
        smallest = 16 * self.smallest
        return min(max(value - min(max(led, -64), 64), smallest), smallest + 16 * (self.count - 1))

    def slope(self, disparities, a, end, y):
        value = lambda i, j: disparities[j][i] if self.inside(i) and 0 <= j < self.height else INVALID
        pairs = [(value(end + k * a, j), value(end + (k + 8) * a, j)) for k in range(16) for j in range(y - 2, y + 3)]
        changes = sorted(min(max(far - near, -128), 127) for near, far in pairs if INVALID not in (near, far))
        return changes[(len(changes) - 1) // 2] if changes else 0

    def weighted_rays(self, disparities, gray, x, y):
        found = [pixel for direction in EIGHT for pixel in self.on_ray(disparities, x, y, direction, 1)]
        weight = lambda u, v: 1 + self.gray_weight(abs(gray[v][u] - gray[y][x]))
        return self.weighted_middle([(disparities[v][u], weight(u, v)) for u, v in found])

    def fill(self, disparities, right, gray):
        limit = 1 if self.case["lr_check"] == "off" else self.case["lr_check"]

        def mismatch(x, y):
            for d in range(self.smallest, self.smallest + self.count):
                if self.inside(x - d) and right[y][x - d] != INVALID and abs(right[y][x - d] // 16 - d) <= limit:
                    return True
            return False

        def step(m, directions, choose):
            def value(x, y):
                values = self.nearest(m, x, y, directions) if m[y][x] == INVALID else []
                return choose(x, y, values) if values else m[y][x]

            return self.over_pixels(value)

        row, column = [(-1, 0), (1, 0)], [(0, -1), (0, 1)]
        smallest = lambda x, y, values: values[0]
        median = lambda x, y, values: values[(len(values) - 1) // 2]
        second = lambda x, y, values: values[min(1, len(values) - 1)]
        kind = self.case["fill"]
        if kind == "none":
            return disparities
        if kind == "rays":
            disparities = step(disparities, row, lambda x, y, v: INVALID if mismatch(x, y) else smallest(x, y, v))
            disparities = step(disparities, EIGHT, median)
        if kind == "weighted-rays":
            unfilled = disparities
            three = lambda x, y, v: INVALID if mismatch(x, y) else self.beside(unfilled, x, y)
            disparities = step(disparities, row, three)
            after = disparities
            disparities = step(disparities, EIGHT, lambda x, y, v: self.weighted_rays(after, gray, x, y))
        if kind == "hirschmuller":
            disparities = step(disparities, EIGHT, lambda *a: median(*a) if mismatch(*a[:2]) else second(*a))
        return step(step(disparities, row, smallest), column, smallest)

    def mirrored(self, kind, samples):
        """An image with its rows reversed."""
        count = SAMPLES[kind][1]
        pixels = [samples[i : i + count] for i in range(0, len(samples), count)]
        rows = [pixels[y * self.width : (y + 1) * self.width] for y in range(self.height)]
        return kind, [sample for row in rows for pixel in reversed(row) for sample in pixel]

    def valid(self, disparities, side):
        """The stage validity, where not all pixels have content; returns what it leaves."""
        if self.contents is None:
            return disparities
        disparities = self.validity(disparities, side)
        yield "validity", [("h", disparities)]
        return disparities

    def views(self, left, right):
        """The stages from the images to the winner; returns both views and the margins. An image is (kind, samples)."""
        case = self.case
        channels = [self.deep_gray(*image) for image in (left, right)]
        gray = self.gray(*left)
        yield "gray", [("H", channels[0]), ("H", channels[1]), ("B", gray)]
        penalties = None
        if "on" in (case["adaptive_p1"], case["adaptive_p2"]) and case["method"] == "sgm":
            penalties = self.penalties(gray)
            yield "penalties", [("B", penalties)]
        if case["prefilter"] == "normalized":
            w = case["prefilter_window"]
            yield "window_sums", [("I", self.window_sums(g, w)) for side in channels for g in side]
        units = [unit_of(image[0]) for image in (left, right)]
        channels = [[self.prefilter(g, unit) for g in side] for side, unit in zip(channels, units)]
        yield "prefilter", [("H", side) for side in channels]
        if case["cost"] == "zsad":
            yield "window_sums", [("I", self.window_sums(f, self.block)) for side in channels for f in side]
        units = units if case["prefilter"] == "none" else [1, 1]
        features = None
        if case["cost"].startswith("learned"):
            statistics = [self.feature_statistics(f, unit) for (f,), unit in zip(channels, units)]
            yield "feature_statistics", [("I", [numbers]) for numbers in statistics]
            features = [self.features(f, unit, of) for (f,), unit, of in zip(channels, units, statistics)]
            yield "features", [("B", side) for side in features]
        sides = [self.descriptors(side, unit) for side, unit in zip(channels, units)]
        if features is not None:
            sides = [self.over_pixels(lambda x, y: f[y][x] + g[y][x]) for f, g in zip(sides, features)]
        if case["cost"] == "bt-gray":
            grays = [self.descriptors([self.gray(*image)], 1) for image in (left, right)]
            sides = [self.over_pixels(lambda x, y: f[y][x] + g[y][x]) for f, g in zip(sides, grays)]
        yield "descriptors", [("B", side) for side in sides]
        if case["cost"] == "mi":
            self.table = yield from self.last_table(*sides)
        found = yield from self.winner_stages(sides[0], sides[1], penalties, gray)
        if case.get("labels", "off") == "on":
            labels = self.over_pixels(lambda x, y: self.costs[y][x].index(min(self.costs[y][x])))
            yield "labels", [("H", labels)]
            yield "energy", [("Q", self.energy(labels, gray))]
        return found

    def winner_stages(self, left, right, penalties, gray):
        """The stages from the descriptors to the winner; returns both views and the margins."""
        columns = self.cost_columns(left, right)
        yield "cost_columns", [("I", columns)]
        cost = self.block_sums(columns)
        yield "block_sums", [("I", cost)]
        self.terms = self.matching_cost(cost)
        if self.case["method"] == "sgm":
            name, cost = "winner", self.terms
            yield "matching_cost", [("B", cost)]
            cost = self.sgm_aggregate(cost, penalties)
            yield "sgm_aggregate", [("H", cost)]
            if self.case["passes"] == 2:
                cost = self.second_cost(self.terms, cost)
                yield "second_cost", [("B", cost)]
                cost = self.sgm_aggregate(cost, penalties)
                yield "sgm_aggregate", [("H", cost)]
        elif self.case["method"] == "bp":
            name, cost = "winner", self.terms
            yield "matching_cost", [("B", cost)]
            coarse = self.coarse_cost(cost)
            if coarse:
                yield "coarse_cost", [("H", terms) for terms in coarse]
            found = self.messages([cost] + coarse, gray)
            yield "messages", [("B", volume) for level in found for volume in level]
            cost = self.over_pixels(lambda x, y: [sum(v) for v in zip(cost[y][x], *(m[y][x] for m in found[-1]))])
            yield "beliefs", [("H", cost)]
        else:
            name = "block_match"
            if self.case["cost"] == "ncc":
                left_blocks = self.block_statistics(left, range(self.width))
                right_columns = range(-(self.smallest + self.count - 1), self.width - self.smallest)
                right_blocks = self.block_statistics(right, right_columns)
                yield "block_statistics", [("I", left_blocks), ("I", right_blocks)]
                cost = self.correlation_costs(cost, left_blocks, right_blocks)
                self.terms = [[[(89 * a + 4096) >> 13 for a in pixel] for pixel in row] for row in cost]
        self.costs = cost
        view, other, margins = self.winner(cost)
        yield name, [("h", view), ("h", other), ("B", margins)]
        return view, other, margins

    def run(self, left, right):
        """All stages in the order of the chain: (name, parts), a part being (C type, values)."""
        case = self.case
        lenses = case.get("rectify", [None, None])
        contents = [self.content(mask, lens) for mask, lens in zip(case.get("masks", [None, None]), lenses)]
        if "rectify" in case:
            pair = zip(lenses, (left, right))
            left, right = [(kind, self.rectify(lens, kind, samples)) for lens, (kind, samples) in pair]
            yield "rectify", [(SAMPLES[kind][0], list(samples)) for kind, samples in (left, right)]
        if self.rules:
            contents[0] = [[has and self.in_rectangle(x, y) for x, has in enumerate(row)] for y, row in enumerate(contents[0])]
        if not all(has for content in contents for row in content for has in row):
            self.contents = contents
            yield "content", [("B", [[int(has) for has in row] for row in content]) for content in contents]
        reads = case["right_map"] == "on" or case["lr_check"] != "off" or case["fill"] in ("rays", "weighted-rays", "hirschmuller")
        matched = None
        if case["right_view"] == "match" and reads:
            second = Chain({**case, "subpixel": "off", "uniqueness": 0, "labels": "off"})
            if self.contents is not None:
                second.contents = [[row[::-1] for row in content] for content in reversed(self.contents)]
            matched, _, _ = yield from second.views(self.mirrored(*right), self.mirrored(*left))
        view, other, margins = yield from self.views(left, right)
        if matched is not None:
            other = [row[::-1] for row in matched]
            yield "mirror", [("h", other)]
        if reads:
            other = yield from self.valid(other, 1)
        view = yield from self.valid(view, 0)
        gray = self.gray(*left)
        for name, off, again, stage in (
            ("texture", 0, False, lambda: self.texture(view, gray)),
            ("lr_check", "off", False, lambda: self.lr_check(view, other)),
            ("speckle_window", 0, False, lambda: self.speckle(view)),
            ("median", "off", True, lambda: self.median(view)),
            ("fill", "none", True, lambda: self.fill(view, other, gray)),
            ("weighted_median", "off", True, lambda: self.weighted_median(view, gray)),
            ("wls", "off", True, lambda: self.wls(view, gray)),
        ):
            if case[name] != off:
                view = stage()
                yield name.replace("_window", ""), [("h", view)]
                if again:
                    view = yield from self.valid(view, 0)
        if case["confidence"] == "on":
            yield "confidence", [("B", self.confidence(view, margins))]
        if case["depth"] != "off":
            yield "depth", [("I", self.depth(view))]


def flat(values):
    return [v for value in values for v in flat(value)] if isinstance(values, list) else [values]


def little_endian(samples):
    if sys.byteorder == "big":
        samples.byteswap()
    return samples


def read(path, code):
    samples = array.array(code)
    with open(path, "rb") as file:
        samples.frombytes(file.read())
    return little_endian(samples)


def as_bytes(parts):
    # An array raises OverflowError where a value does not fit the width of the page.
    return b"".join(little_endian(array.array(code, flat(values))).tobytes() for code, values in parts)


def run_case(folder):
    with open(os.path.join(folder, "case.json"), encoding="utf-8") as file:
        case = json.load(file)
    names = (os.path.join(folder, side + ".raw") for side in ("left", "right"))
    images = [(kind, read(name, SAMPLES[kind][0])) for kind, name in zip(case["formats"], names)]
    for n, (stage, parts) in enumerate(Chain(case).run(*images)):
        with open(os.path.join(folder, "%03d_%s.raw" % (n, stage)), "wb") as file:
            file.write(as_bytes(parts))


# The pair of docs/VECTORS.md.


def mixed(x, y, c):
    h = (374761393 * x + 668265263 * y + 2246822519 * c) % 2**32
    h = (h ^ (h >> 15)) * 2654435761 % 2**32
    h = (h ^ (h >> 13)) * 3266489917 % 2**32
    return (h ^ (h >> 16)) % 2**16


def paint(x, y, c):
    if y >= 27 and x < 24:
        return 40000
    grain = sum(mixed(x + i, y + j, c) for i in (0, 1) for j in (0, 1)) >> 2
    return clamp(2 * grain - 32768, 0, 65535)


def seen_right(x, y, c):
    if 7 <= y <= 20 and 9 <= x <= 22:
        v = paint(x + 11, y, c)
    elif 30 <= x <= 36 and 22 <= y <= 26:
        v = mixed(x, y, c + 4)
    else:
        v = paint(x + 5, y, c)
    return min(v + (mixed(x, y, c + 8) >> 7), 65535)


def formula_network():
    """That of docs/VECTORS.md."""
    layers = [("convolution", True, 8, 9), ("depthwise", False, 8, 9), ("point", True, 12, 8), ("point", False, 8, 12)]

    def output(n, o, each):
        weights = [mixed(k, o, 16 + n) % 255 - 127 for k in range(each)]
        bias, multiplier, shift = (mixed(o, i, 24 + n) % m for i, m in enumerate((2001, 300, 3)))
        return weights, bias - 1000, multiplier + 100, shift + 14

    return [
        (kind, relu, [output(n, o, each) for o in range(outputs)]) for n, (kind, relu, outputs, each) in enumerate(layers)
    ]


def vector_image(case, formula, kind):
    code, channels = SAMPLES[kind]
    shift = 8 if code == "B" else 0
    size = case["width"], case["height"]
    return kind, [formula(x, y, c) >> shift for y in range(size[1]) for x in range(size[0]) for c in range(channels)]


def vector_masks(case):
    def has_left(x, y):
        return not (3 <= x <= 9 and 13 <= y <= 17) and x < case["width"] - 2

    def has_right(x, y):
        return (x - 28) ** 2 + (y - 9) ** 2 > 10

    pixels = [(x, y) for y in range(case["height"]) for x in range(case["width"])]
    return [[1 + x + y if has(x, y) else 0 for x, y in pixels] for has in (has_left, has_right)]


def vectors(path):
    with open(path, encoding="utf-8") as file:
        known = json.load(file)["vectors"]
    count = 0
    for vector in known:
        case = vector["case"]
        case["masks"] = vector_masks(case) if case["masks"] == "on" else [None, None]
        images = [vector_image(case, *of) for of in zip((paint, seen_right), case["formats"])]
        found = [(stage, as_bytes(parts)) for stage, parts in Chain(case).run(*images)]
        found = [[stage, len(data), "%08x" % zlib.crc32(data)] for stage, data in found]
        for n, (mine, theirs) in enumerate(zip(found, vector["stages"])):
            if mine != theirs:
                sys.exit("%s, stage %d: %s by the page and %s in the file" % (vector["name"], n, mine, theirs))
        if len(found) != len(vector["stages"]):
            counts = vector["name"], len(found), len(vector["stages"])
            sys.exit("%s: %d stages by the page and %d in the file" % counts)
        count += len(found)
    print("%d vectors, %d stages" % (len(known), count))


EXAMPLE = dict(
    width=6, height=1, method="sgm", cost="sad", census="5x5", color_cost="off", ad_weight=8,
    census_weight=32, learned_weight=40, paths=4, min_disparity=0, disparities=3, block=3, prefilter="none", prefilter_cap=31,
    prefilter_window=9, p1=2, p2=6, adaptive_p1="off", adaptive_p2="off", p2_step=10, passes=1, texture=0, uniqueness=0, lr_check=0,
    right_view="diagonal", speckle_window=0, speckle_range=2, median=3, fill="none", subpixel="parabola", weighted_median="off", wls="off",
    opencv_rules="off", right_map="off", confidence="off", depth="off",
)
EXAMPLE_PAIR = [10, 40, 70, 60, 200, 90], [40, 66, 190, 210, 90, 90]


def example():
    """The tables of the worked example."""
    chain = Chain(EXAMPLE)
    left, right = EXAMPLE_PAIR
    stages = dict(chain.run(("gray8", left), ("gray8", right)))
    row = lambda name, part=0: stages[name][part][1][0]
    cost = [row("matching_cost")]

    def show(title, values, first=0, name="d"):
        print(title)
        if isinstance(values[0], list):
            values = list(zip(*values))
            print("      x " + "".join("%6d" % (first + x) for x in range(len(values[0]))))
            for d, row in enumerate(values):
                print("  %s = %d " % (name, d) + "".join("%6d" % v for v in row))
        else:
            print("        " + "".join("%6s" % ("inv" if v == INVALID else v) for v in values))

    show("left gray", left)
    show("right gray", right)
    show("cost_columns, x = c - 1", row("cost_columns"), -1)
    show("block sums", row("block_sums"))
    show("matching_cost C, scale = %d" % chain.scale(), cost[0])
    show("L of (0, 1) and of (0, -1): one row, so every path starts and L = C", chain.path_costs(cost, None, 0, 1)[0])
    show("L of (1, 0)", chain.path_costs(cost, None, 1, 0)[0])
    show("L of (-1, 0)", chain.path_costs(cost, None, -1, 0)[0])
    show("sgm_aggregate S", row("sgm_aggregate"))
    show("winner, left view", row("winner"))
    show("winner, right view", row("winner", 1))
    show("lr_check", row("lr_check"))
    show("median", row("median"))
    others = Chain(dict(EXAMPLE, cost="census"))
    show("descriptors of the left image with the cost census, 5x5", others.descriptors([[EXAMPLE_PAIR[0]]], 1)[0], name="k")


if __name__ == "__main__":
    if sys.argv[1:] == ["--example"]:
        example()
    elif len(sys.argv) == 3 and sys.argv[1] == "--vectors":
        vectors(sys.argv[2])
    elif len(sys.argv) == 2:
        folders = sorted(entry.path for entry in os.scandir(sys.argv[1]) if entry.is_dir())
        for folder in folders:
            run_case(folder)
        print("%d cases" % len(folders))
    else:
        sys.exit(__doc__)
