"""docs/EVALUATION.md once more, in plain Python: following that page alone.

    python3 evaluation.py [--each CASES] | ESTIMATE TRUTH [--scale S] [--gt-scale S] [--gt-mask FILE] [--picture FILE]

prints the figures as one JSON object; with --picture writes the picture of the errors as PPM. CASES: a file with such a
command line in each line. Needs nothing but Python 3.8; reads gray PNG, PGM of 8 bits, PFM and NumPy.
"""

import argparse
import array
import ast
import json
import math
import re
import shlex
import struct
import sys
import zlib

CLASSES = [
    (0, (49, 54, 149)), (1 / 16, (69, 117, 180)), (1 / 8, (116, 173, 209)), (1 / 4, (171, 217, 233)),
    (1 / 2, (224, 243, 248)), (1, (254, 224, 144)), (2, (253, 174, 97)), (4, (244, 109, 67)), (8, (215, 48, 39)),
    (16, (165, 0, 38)),
]  # fmt: skip


def swapped(values, little):
    if (sys.byteorder == "little") != little:
        values.byteswap()
    return values


def png(data):
    """Width, height, values, bits of a gray PNG without interlacing."""
    at, packed = 8, b""
    while at < len(data):
        (length,), kind = struct.unpack(">I", data[at : at + 4]), data[at + 4 : at + 8]
        chunk = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, bits, color, _, _, interlaced = struct.unpack(">IIBBBBB", chunk)
            assert color in (0, 3) and not interlaced, "no gray PNG"
            gray = [v * 255 // ((1 << bits) - 1) for v in range(1 << min(bits, 8))]
        elif kind == b"PLTE":
            gray = chunk[::3]
        elif kind == b"IDAT":
            packed += chunk
        at += 12 + length
    raw, step = zlib.decompress(packed), max(bits // 8, 1)
    stride, values = (width * bits + 7) // 8, array.array("H" if bits == 16 else "B")
    above = bytearray(stride)
    for y in range(height):
        start = y * (stride + 1)
        kind, row = raw[start], bytearray(raw[start + 1 : start + 1 + stride])
        if kind:
            for i in range(stride):
                a = row[i - step] if i >= step else 0
                b, c = above[i], above[i - step] if i >= step else 0
                if kind == 4:
                    p = a + b - c
                    add = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
                else:
                    add = (a, b, (a + b) // 2)[kind - 1]
                row[i] = (row[i] + add) & 255
        if bits < 8:
            each = 8 // bits
            places = ((x // each, 8 - bits - x % each * bits) for x in range(width))
            values.extend(gray[row[i] >> shift & (1 << bits) - 1] for i, shift in places)
        else:
            values.frombytes(bytes(row))
        above = row
    return width, height, swapped(values, False) if bits == 16 else values, bits


def floats(values):
    return [v if math.isfinite(v) else None for v in values]


def read(path, scale, integers=False):
    """Width, height and values in px, None where there is none; whole numbers as they are."""
    with open(path, "rb") as file:
        data = file.read()
    if data.startswith(b"\x89PNG"):
        width, height, values, bits = png(data)
        scale = scale or (256 if bits == 16 else None)
    elif data.startswith(b"P5"):
        header = re.match(rb"P5\s+(\d+)\s+(\d+)\s+(\d+)\s", data)
        width, height, values = int(header[1]), int(header[2]), array.array("B", data[header.end() :])
    elif data.startswith(b"Pf"):
        header = re.match(rb"Pf\s+(\d+)\s+(\d+)\s+(\S+)\s", data)
        width, height = int(header[1]), int(header[2])
        values = swapped(array.array("f", data[header.end() :]), float(header[3]) < 0)
        rows = [values[y * width : (y + 1) * width] for y in range(height)]
        return width, height, [v and v / (scale or 1) for row in reversed(rows) for v in floats(row)]
    elif data.startswith(b"\x93NUMPY\x01"):
        (length,) = struct.unpack("<H", data[8:10])
        header = ast.literal_eval(data[10 : 10 + length].decode().strip())
        (height, width), kind = header["shape"], header["descr"]
        codes = {"f4": "f", "f8": "d", "u1": "B", "u2": "H"}
        values = swapped(array.array(codes[kind[1:]], data[10 + length :]), kind[0] in "<|")
        if header["fortran_order"]:
            values = [values[x * height + y] for y in range(height) for x in range(width)]
        if kind[1] == "f":
            return width, height, [v and v / (scale or 1) for v in floats(values)]
    else:
        raise ValueError(f"{path}: unknown format")
    assert len(values) == width * height
    if integers:
        return width, height, values
    return width, height, [v / scale if v else None for v in values]


def in_32_bits(values):
    return [None if v is None else struct.unpack("f", struct.pack("f", v))[0] for v in values]


def interpolated(width, values):
    rows = []
    for start in range(0, len(values), width):
        row = values[start : start + width]
        known = [x for x, v in enumerate(row) if v is not None]
        if known:
            for left, right in zip(known, known[1:]):
                row[left + 1 : right] = [min(row[left], row[right])] * (right - left - 1)
            row[: known[0]] = [row[known[0]]] * known[0]
            row[known[-1] :] = [row[known[-1]]] * (width - known[-1])
        rows.append(row)
    filled = [y for y, row in enumerate(rows) if row[0] is not None]
    if filled:
        rows[: filled[0]] = [rows[filled[0]]] * filled[0]
        rows[filled[-1] :] = [rows[filled[-1]]] * (len(rows) - filled[-1])
    return [-1 if v is None else v for row in rows for v in row]


def figures(width, estimate, truth, mask=None):
    """The figures of docs/EVALUATION.md; None in `estimate` and `truth` where there is none, `mask` of whether pixels count."""
    counted = [i for i, g in enumerate(truth) if g is not None and (mask is None or mask[i])]
    valid = [i for i in counted if estimate[i] is not None]
    errors = sorted(abs(estimate[i] - truth[i]) for i in valid)
    filled = interpolated(width, estimate)
    n = len(errors)

    def of_valid(amount):
        return amount / n if n else None

    def d1(values, i):
        e = abs(values[i] - truth[i])
        return e > 3 and 20 * e > abs(truth[i])

    found = {"pixels": len(counted), "density": n / len(counted)}
    for t in (0.5, 1, 2, 4):
        name = "bad_" + str(t).replace(".", "_")
        bad = sum(e > t for e in errors)
        found[name] = (len(counted) - n + bad) / len(counted)
        found[name + "_of_valid"] = of_valid(bad)
    found["average_error"] = of_valid(math.fsum(errors))
    found["rms_error"] = math.sqrt(math.fsum(e * e for e in errors) / n) if n else None
    for percent in (50, 90, 95, 99):
        found[f"a{percent}"] = errors[n * percent // 100] if n else None
    found["d1_est"] = of_valid(sum(d1(estimate, i) for i in valid))
    found["d1_all"] = sum(d1(filled, i) for i in counted) / len(counted)
    return found


def picture(width, height, estimate, truth, mask):
    filled = interpolated(width, estimate)

    def color(i):
        e, g = abs(filled[i] - truth[i]), abs(truth[i])
        n = min(e / 3, 20 * e / g if g else (math.inf if e else 0))
        chosen = [rgb for least, rgb in CLASSES if n >= least][-1]
        return chosen if mask is None or mask[i] else tuple(v // 2 for v in chosen)

    pixels = bytearray()
    for y in range(height):
        for x in range(width):
            near = [
                v * width + u
                for v in range(max(y - 1, 0), min(y + 2, height))
                for u in range(max(x - 1, 0), min(x + 2, width))
                if truth[v * width + u] is not None
            ]
            here = y * width + x
            pixels += bytes(color(here if truth[here] is not None else near[-1]) if near else (0, 0, 0))
    return b"P6 %d %d 255\n" % (width, height) + pixels


def case(arguments):
    parser = argparse.ArgumentParser()
    parser.add_argument("estimate")
    parser.add_argument("truth")
    parser.add_argument("--scale", type=float)
    parser.add_argument("--gt-scale", type=float)
    parser.add_argument("--gt-mask")
    parser.add_argument("--picture")
    given = parser.parse_args(arguments)
    width, height, estimate = read(given.estimate, given.scale)
    *size, truth = read(given.truth, given.gt_scale)
    assert size == [width, height]
    estimate, truth = in_32_bits(estimate), in_32_bits(truth)
    mask = given.gt_mask and [v == 255 for v in read(given.gt_mask, None, integers=True)[2]]
    if given.picture:
        with open(given.picture, "wb") as file:
            file.write(picture(width, height, estimate, truth, mask))
    return figures(width, estimate, truth, mask)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--each"]:
        with open(sys.argv[2]) as lines:
            for line in lines:
                print(json.dumps(case(shlex.split(line))))
    else:
        print(json.dumps(case(sys.argv[1:])))
