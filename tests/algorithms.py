"""docs/ALGORITHMS.md once more, in plain Python: following that page alone, to show that it is enough.

    python3 algorithms.py FOLDER    for each case in FOLDER (case.json, left.raw, right.raw), write STAGE.raw beside it
    python3 algorithms.py --example print the worked example of the page

Needs nothing but Python 3.8. Raw files are little endian; tests/algorithms.rs writes the cases and compares the stages.
"""

import array
import json
import math
import os
import sys

INVALID = -32768
# A census: columns, rows, bits.
CENSUS = {"5x5": (5, 5, 24), "7x7": (7, 7, 48), "9x7": (9, 7, 62), "cs9x7": (9, 7, 31)}
SAMPLES = {"gray8": ("B", 1), "gray16": ("H", 1), "rgba8": ("B", 4), "rgba16": ("H", 4)}
THREE = [(0, 1), (1, 0), (-1, 0)]
FOUR = THREE + [(0, -1)]
EIGHT = FOUR + [(1, 1), (-1, -1), (-1, 1), (1, -1)]


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


class Chain:
    """The stages by their names. Images are [y][x], volumes [y][x][d]."""

    def __init__(self, case):
        self.width, self.height = case["width"], case["height"]
        self.smallest, self.count = case["min_disparity"], case["disparities"]
        self.case = case
        self.cap, self.block = case["prefilter_cap"], case["block"]
        self.radius = (self.block - 1) // 2
        self.census_bits = CENSUS[case["census"]][2]
        self.census_bytes = -(-self.census_bits // 8) if "census" in case["cost"] else 0
        self.largest_total = self.block**2 * self.largest_pixel_cost()
        self.narrowing = max(0, self.largest_total.bit_length() - 20)

    def inside(self, x):
        return 0 <= x <= self.width - 1

    def points_inside(self, x, v):
        return self.inside(x - q(v))

    def at(self, image, x, y):
        return image[clamp(y, 0, self.height - 1)][clamp(x, 0, self.width - 1)]

    def over_pixels(self, formula):
        return [[formula(x, y) for x in range(self.width)] for y in range(self.height)]

    def deep_gray(self, kind, samples):
        """The channels at the depth of the samples."""

        def sample(i):
            return self.over_pixels(lambda x, y: samples[(y * self.width + x) * SAMPLES[kind][1] + i])

        if kind.startswith("gray"):
            return [sample(0)] * (3 if self.case["color_cost"] else 1)
        colours = [sample(i) for i in (0, 1, 2)]
        return colours if self.case["color_cost"] else [self.luma(kind, samples)]

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

    def derivatives(self, image, u, x, y):
        """Gx and Gy."""

        def at(i, j):
            return self.at(image, x + i, y + j)

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
                return self.clipped((n * (4 * g[y][x] + beside) - 8 * sums[y][x]) // (2 * n * u))
            gx, gy = self.derivatives(g, u, x, y)
            return self.clipped(gx) if kind == "xsobel" else min(math.isqrt(gx * gx + gy * gy), 2 * self.cap)

        return self.over_pixels(value)

    def census(self, f, x, y):
        """The census string as bytes."""
        columns, rows, bits = CENSUS[self.case["census"]]
        window = [
            self.at(f, x + k % columns - columns // 2, y + k // columns - rows // 2) for k in range(columns * rows)
        ]
        c = (columns * rows - 1) // 2
        if self.case["census"] == "cs9x7":
            pairs = [(window[k], window[62 - k]) for k in range(31)]
        else:
            pairs = [(window[k], window[c]) for k in range(2 * c + 1) if k != c]
        string = int("".join("1" if a < b else "0" for a, b in pairs), 2)
        return list(string.to_bytes(self.census_bytes, "little"))

    def features(self, channels, u):
        cost, n = self.case["cost"], self.block**2

        def of_channel(f, sums, x, y):
            v = level(f[y][x], u)
            if cost in ("sad", "ssd"):
                return [v]
            if cost == "zsad":
                z = (2 * (n * f[y][x] - sums[y][x]) + n * u) // (2 * n * u)
                return [clamp(z, -127, 127) + 127]
            if cost == "bt":
                a, b = ((v + level(self.at(f, x + i, y), u)) // 2 for i in (-1, 1))
                return [v, min(v, a, b), max(v, a, b)]
            found = self.census(f, x, y) if self.census_bytes else []
            if cost in ("sad-xy", "census-sobel"):
                found += [self.clipped(g) for g in self.derivatives(f, u, x, y)]
            if cost == "ad-census":
                found.append(v)
            return found

        sums = [self.window_sums(f, self.block) if cost == "zsad" else None for f in channels]
        return self.over_pixels(lambda x, y: [v for f, s in zip(channels, sums) for v in of_channel(f, s, x, y)])

    def blend(self, a, b):
        return min(255, (self.case["ad_weight"] * a + self.case["census_weight"] * b + 8) >> 4)

    def largest_pixel_cost(self):
        v = 255 if self.case["prefilter"] == "none" else 2 * self.cap
        return {
            "sad": v,
            "ssd": v * v,
            "zsad": min(2 * v, 254),
            "bt": v,
            "sad-xy": 4 * self.cap,
            "census": self.census_bits,
            "census-sobel": 2 * self.census_bits + 4 * self.cap,
            "ad-census": max(1, self.blend(v, self.census_bits)),
        }[self.case["cost"]]

    def pixel_cost(self, l, p):
        cost, i = self.case["cost"], self.census_bytes
        if cost == "bt":

            def between(i):
                def outside(v, low, high):
                    return max(0, low - v, v - high)

                return min(outside(l[i], p[i + 1], p[i + 2]), outside(p[i], l[i + 1], l[i + 2]))

            return three(*map(between, (0, 3, 6))) if self.case["color_cost"] else between(0)
        difference = [abs(a - b) for a, b in zip(l, p)]
        bits = sum(bin(a ^ b).count("1") for a, b in zip(l[:i], p[:i]))
        if cost == "sad":
            return three(*difference) if self.case["color_cost"] else difference[0]
        if cost == "ssd":
            return difference[0] ** 2
        if cost == "zsad":
            return difference[0]
        if cost == "sad-xy":
            return difference[0] + difference[1]
        if cost == "census":
            return bits
        if cost == "census-sobel":
            return 2 * bits + difference[i] + difference[i + 1]
        return self.blend(difference[i], bits)

    def cost_columns(self, left, right):
        columns = range(-self.radius, self.width + self.radius)

        def costs(y):
            return [
                [self.pixel_cost(self.at(left, x, y), self.at(right, x - (self.smallest + d), y)) for d in range(self.count)]
                for x in columns
            ]

        # Both images are continued by the same rows, so the pixel costs are, too.
        rows = [costs(y) for y in range(self.height)]

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
        top = 164 * 248 if self.case["cost"] == "census-sobel" else 59 * 1550
        return (top * 2**14 + largest // 2) // largest

    def matching_cost(self, sums):
        scale = self.scale()
        return [[[(s * scale + 2**23) >> 24 for s in pixel] for pixel in row] for row in sums]

    def path_costs(self, cost, dx, dy):
        """L of one direction. Pixels are visited so that the pixel before comes first."""
        p1, p2 = self.case["p1"], self.case["p2"]
        path = self.over_pixels(lambda x, y: None)
        for y in range(self.height) if dy >= 0 else reversed(range(self.height)):
            for x in range(self.width) if dx >= 0 else reversed(range(self.width)):
                smooth = [0] * self.count
                if self.inside(x - dx) and 0 <= y - dy < self.height:
                    before = path[y - dy][x - dx]
                    m = min(before)
                    for d, stay in enumerate(before):
                        steps = [before[e] + p1 for e in (d - 1, d + 1) if 0 <= e < self.count]
                        smooth[d] = min([stay, m + p2] + steps) - m
                path[y][x] = [c + t for c, t in zip(cost[y][x], smooth)]
        return path

    def sgm_aggregate(self, cost):
        paths = [self.path_costs(cost, dx, dy) for dx, dy in {3: THREE, 4: FOUR, 8: EIGHT}[self.case["paths"]]]
        return self.over_pixels(lambda x, y: [sum(values) for values in zip(*(path[y][x] for path in paths))])

    def winner(self, cost):
        last, ratio = self.count - 1, self.case["uniqueness"]

        def left(x, y):
            s = cost[y][x]
            best = s.index(min(s))
            if ratio > 0:
                for d in range(self.count):
                    if abs(d - best) > 1 and not s[d] * (100 - ratio) > s[best] * 100:
                        return INVALID
            v = 16 * (self.smallest + best)
            if self.case["subpixel"] and 0 < best < last:
                a, b, c = s[best - 1 : best + 2]
                k = a + c - 2 * b
                v += (16 * (a - c) + k - 1) // (2 * k)
            return v if self.points_inside(x, v) else INVALID

        def right(x, y):
            least, value = None, INVALID
            for d in range(self.count):
                seen_from = x + self.smallest + d
                if self.inside(seen_from) and (least is None or cost[y][seen_from][d] < least):
                    least, value = cost[y][seen_from][d], 16 * (self.smallest + d)
            return value

        return self.over_pixels(left), self.over_pixels(right)

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

    def median(self, disparities):
        if self.case["median"] == "off":
            return disparities

        def fifth(x, y):
            v = sorted(self.at(disparities, x + i, y + j) for j in (-1, 0, 1) for i in (-1, 0, 1))[4]
            return v if self.points_inside(x, v) else INVALID

        return self.over_pixels(fifth)

    def run(self, left, right):
        """All stages in the order of the chain: (name, C type, values)."""
        sides = []
        for side, samples in (("left", left), ("right", right)):
            kind = self.case["format"]
            yield "gray_" + side, "B", self.gray(kind, samples)
            channels, unit = self.deep_gray(kind, samples), unit_of(kind)
            yield "deep_gray_" + side, "H", channels
            channels = [self.prefilter(g, unit) for g in channels]
            yield "prefilter_" + side, "H", channels
            features = self.features(channels, unit if self.case["prefilter"] == "none" else 1)
            yield "features_" + side, "B", features
            sides.append(features)
        columns = self.cost_columns(*sides)
        yield "cost_columns", "I", columns
        cost = self.block_sums(columns)
        yield "block_sums", "I", cost
        if self.case["method"] == "sgm":
            cost = self.matching_cost(cost)
            yield "matching_cost_scale", "I", [self.scale()]
            yield "matching_cost", "B", cost
            cost = self.sgm_aggregate(cost)
            yield "sgm_aggregate", "H", cost
        view, other = self.winner(cost)
        yield "winner_left", "h", view
        yield "winner_right", "h", other
        view = self.lr_check(view, other)
        yield "lr_check", "h", view
        yield "median", "h", self.median(view)


def flat(values):
    return [v for value in values for v in flat(value)] if isinstance(values, list) else [values]


def read(path, code):
    samples = array.array(code)
    with open(path, "rb") as file:
        samples.frombytes(file.read())
    if sys.byteorder == "big":
        samples.byteswap()
    return samples


def write(path, code, values):
    samples = array.array(code, flat(values))  # raises OverflowError where a value does not fit the width of the page
    if sys.byteorder == "big":
        samples.byteswap()
    with open(path, "wb") as file:
        file.write(samples.tobytes())


def run_case(folder):
    with open(os.path.join(folder, "case.json"), encoding="utf-8") as file:
        case = json.load(file)
    code = SAMPLES[case["format"]][0]
    images = [read(os.path.join(folder, side + ".raw"), code) for side in ("left", "right")]
    for name, code, values in Chain(case).run(*images):
        write(os.path.join(folder, name + ".raw"), code, values)


EXAMPLE = dict(
    width=6, height=1, format="gray8", method="sgm", cost="sad", census="5x5", color_cost=False, ad_weight=8,
    census_weight=32, paths=4, min_disparity=0, disparities=3, block=3, prefilter="none", prefilter_cap=31,
    prefilter_window=9, p1=2, p2=6, uniqueness=0, lr_check=0, median=3, subpixel=True,
)
EXAMPLE_PAIR = [10, 40, 70, 60, 200, 90], [40, 66, 190, 210, 90, 90]


def example():
    """The tables of the worked example."""
    chain = Chain(EXAMPLE)
    stages = {name: values[0] for name, _, values in chain.run(*EXAMPLE_PAIR)}
    cost = [stages["matching_cost"]]

    def show(title, values, first=0, name="d"):
        print(title)
        if isinstance(values[0], list):
            values = list(zip(*values))
            print("      x " + "".join("%6d" % (first + x) for x in range(len(values[0]))))
            for d, row in enumerate(values):
                print("  %s = %d " % (name, d) + "".join("%6d" % v for v in row))
        else:
            print("        " + "".join("%6s" % ("inv" if v == INVALID else v) for v in values))

    show("left gray", stages["gray_left"])
    show("right gray", stages["gray_right"])
    show("cost_columns, x = c - 1", stages["cost_columns"], -1)
    show("block sums", stages["block_sums"])
    show("matching_cost C, scale = %d" % chain.scale(), cost[0])
    show("L of (0, 1) and of (0, -1): one row, so every path starts and L = C", chain.path_costs(cost, 0, 1)[0])
    show("L of (1, 0)", chain.path_costs(cost, 1, 0)[0])
    show("L of (-1, 0)", chain.path_costs(cost, -1, 0)[0])
    show("sgm_aggregate S", stages["sgm_aggregate"])
    show("winner, left view", stages["winner_left"])
    show("winner, right view", stages["winner_right"])
    show("lr_check", stages["lr_check"])
    show("median", stages["median"])
    others = Chain(dict(EXAMPLE, cost="census"))
    show("features of the left image with the cost census, 5x5", others.features([[EXAMPLE_PAIR[0]]], 1)[0], name="i")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--example":
        example()
    else:
        folders = sorted(entry.path for entry in os.scandir(sys.argv[1]) if entry.is_dir())
        for folder in folders:
            run_case(folder)
        print("%d cases" % len(folders))
