"""Reads what --depth and --points wrote, and computes it again from the disparities: f B / (d + doffs).

    python3 depth.py FOLDER FOCAL BASELINE DOFFS CX CY [TRUTH.pfm]

FOLDER holds map.npy, left.ppm (or none) and what was written: depth.png, .pfm, .npy, .tif, scene.ply, scene.pcd. With a
truth of the disparities, prints the median and the 90th percentile of the relative error of the depth. Needs nothing but
Python 3.8.
"""

import ast
import math
import os
import re
import struct
import sys
import zlib


def read(path):
    with open(path, "rb") as file:
        return file.read()


def floats(data, order="<"):
    return list(struct.unpack("%s%df" % (order, len(data) // 4), data))


def npy(data):
    assert data[:6] == b"\x93NUMPY"
    length = struct.unpack("<H", data[8:10])[0]
    header = ast.literal_eval(data[10 : 10 + length].decode())
    assert header["descr"] == "<f4" and not header["fortran_order"], header
    return header["shape"], floats(data[10 + length :])


def pfm(data):
    kind, size, scale, rest = data.split(b"\n", 3)
    width, height = map(int, size.split())
    assert kind == b"Pf"
    values = floats(rest, "<" if float(scale) < 0 else ">")
    assert len(values) == width * height
    return (height, width), [v for y in reversed(range(height)) for v in values[y * width : (y + 1) * width]]


def png16(data):
    """A gray PNG of 16 bits without interlacing."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color, _, _, interlace = struct.unpack(">IIBBBBB", body)
            assert (depth, color, interlace) == (16, 0, 0)
        packed += body if kind == b"IDAT" else b""
        at += 12 + length
    raw, line, values = zlib.decompress(packed), 2 * width, []
    before = bytearray(line)
    for y in range(height):
        kind, row = raw[y * (line + 1)], bytearray(raw[y * (line + 1) + 1 : (y + 1) * (line + 1)])
        for i in range(line):
            a, b, c = (row[i - 2] if i > 1 else 0), before[i], (before[i - 2] if i > 1 else 0)
            nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
            row[i] = (row[i] + [0, a, b, (a + b) // 2, nearest][kind]) & 255
        before = row
        values += struct.unpack(">%dH" % width, row)
    return (height, width), values


def tiff(data):
    """One sample of 32 bits, a float, a pixel; in strips, as they are."""
    assert data[:4] == b"II*\0"
    at = struct.unpack("<I", data[4:8])[0]
    tags = {}
    for i in range(struct.unpack("<H", data[at : at + 2])[0]):
        tag, kind, count = struct.unpack("<HHI", data[at + 2 + 12 * i : at + 10 + 12 * i])
        size, code = {1: (1, "B"), 3: (2, "H"), 4: (4, "I")}.get(kind, (0, ""))
        if size:
            where = at + 10 + 12 * i
            where = where if size * count <= 4 else struct.unpack("<I", data[where : where + 4])[0]
            tags[tag] = struct.unpack("<%d%s" % (count, code), data[where : where + size * count])
    assert tags[258] == (32,) and tags[339] == (3,) and tags.get(259, (1,)) == (1,), tags
    strips = [data[start : start + length] for start, length in zip(tags[273], tags[279])]
    return (tags[257][0], tags[256][0]), floats(b"".join(strips))


def ppm(data):
    header = re.match(rb"P6\s+(\d+)\s+(\d+)\s+255\s", data)
    width, height, rest = int(header[1]), int(header[2]), data[header.end() :]
    return [tuple(rest[i : i + 3]) for i in range(0, 3 * width * height, 3)]


def ply(data):
    header, body = data.split(b"end_header\n", 1)
    lines = header.decode().split("\n")
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"], lines
    count = [int(line.split()[2]) for line in lines if line.startswith("element vertex")]
    properties = [line.split()[1:] for line in lines if line.startswith("property")]
    assert properties == [["float", n] for n in "xyz"] + [["uchar", n] for n in ("red", "green", "blue")], properties
    assert len(body) == 15 * count[0]
    return list(struct.iter_unpack("<fffBBB", body))


def pcd(data):
    header, body = data.split(b"DATA binary\n", 1)
    fields = dict(line.split(" ", 1) for line in header.decode().strip().split("\n"))
    assert fields["FIELDS"] == "x y z rgb" and fields["SIZE"] == "4 4 4 4" and fields["TYPE"] == "F F F F", fields
    assert fields["COUNT"] == "1 1 1 1" and fields["HEIGHT"] == "1" and fields["WIDTH"] == fields["POINTS"], fields
    assert len(body) == 16 * int(fields["POINTS"])
    points = struct.iter_unpack("<fffI", body)
    return [(x, y, z, c >> 16, c >> 8 & 255, c & 255) for x, y, z, c in points]


def near(a, b, most):
    return abs(a - b) <= most


def main(folder, focal, baseline, doffs, cx, cy, truth=None):
    there = lambda name: os.path.join(folder, name)
    shape, disparities = npy(read(there("map.npy")))
    width, found = shape[1], []
    for d in disparities:
        z = focal * baseline / (d + doffs) if d == d and d + doffs > 0 else math.inf
        found.append(z if z < 2**32 * 1e-6 else None)
    valid = [z for z in found if z is not None]
    assert len(valid) > 800 and len(set(valid)) > 10, len(valid)
    # doffs is known to 1/8192 px, the depth to a micrometre, a float to 2^-24 of it.
    room = lambda z: 1e-6 + 1e-7 * z + (z * z / (focal * baseline) / 8192 if doffs * 4096 % 1 else 0)
    for name, reader, none in (("pfm", pfm, math.inf), ("npy", npy, math.nan), ("tif", tiff, math.nan)):
        size, values = reader(read(there("depth." + name)))
        assert size == shape, (name, size)
        for i, (value, z) in enumerate(zip(values, found)):
            same = (value == none or value != value and none != none) if z is None else near(value, z, room(z))
            assert same, (name, i, value, z)
    size, values = png16(read(there("depth.png")))
    assert size == shape
    for i, (value, z) in enumerate(zip(values, found)):
        assert (value == 0) if z is None or z > 65.536 else near(value, 1000 * z, 0.5 + 1000 * room(z)), (i, value, z)
    image = ppm(read(there("left.ppm"))) if os.path.exists(there("left.ppm")) else None
    for name, points in (("ply", ply(read(there("scene.ply")))), ("pcd", pcd(read(there("scene.pcd"))))):
        assert len(points) == len(valid), (name, len(points))
        pixels = ((i, z) for i, z in enumerate(found) if z is not None)
        for (x, y, forward, *color), (i, z) in zip(points, pixels):
            expected = ((i % width - cx) * z / focal, (i // width - cy) * z / focal, z)
            most = 2 * room(z) * (1 + width / focal)
            assert all(near(a, b, most) for a, b in zip((x, y, forward), expected)), (name, i, x, y, forward, expected)
            assert image is None or tuple(color) == image[i], (name, i, color)
    if truth:
        size, true = pfm(read(truth))
        errors = []
        for z, d in zip(found, true):
            if z is not None and math.isfinite(d):
                far = focal * baseline / (d + doffs)
                errors.append(abs(z - far) / far)
        errors.sort()
        print(len(errors), errors[len(errors) // 2], errors[9 * len(errors) // 10])


if __name__ == "__main__":
    main(sys.argv[1], *map(float, sys.argv[2:7]), *sys.argv[7:])
