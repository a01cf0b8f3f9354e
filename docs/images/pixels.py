"""Pictures and maps in plain Python: what docs/gallery.py cuts crops from and draws. Needs Python 3.8 alone.

A picture is a list of rows, a row a list of (red, green, blue); a map the same with a number or None, where nothing is known.
"""

import array
import pathlib
import struct
import sys
import zlib


def read_png(path):
    """Rows of the samples of each pixel, of a PNG of 8 or 16 bits without interlace or palette."""
    data = pathlib.Path(path).read_bytes()
    place, packed = 8, b""
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        body = data[place + 8 : place + 8 + length]
        if kind == b"IHDR":
            width, height, bits, colour, _, _, interlace = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            packed += body
        place += 12 + length
    if interlace or colour not in (0, 2, 4, 6) or bits not in (8, 16):
        raise ValueError(f"{path}: a PNG of another kind")
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    step, raw = channels * bits // 8, zlib.decompress(packed)
    stride, rows = width * step, []
    before = bytearray(stride)
    for y in range(height):
        kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1 : (y + 1) * (stride + 1)])
        unfilter(kind, line, before, step)
        before = line
        samples = line if bits == 8 else struct.unpack(f">{stride // 2}H", line)
        rows.append([tuple(samples[i : i + channels]) for i in range(0, len(samples), channels)])
    return rows


def unfilter(kind, line, before, step):
    for i in range(len(line)):
        left = line[i - step] if i >= step else 0
        corner = before[i - step] if i >= step else 0
        if kind == 1:
            line[i] = (line[i] + left) & 255
        elif kind == 2:
            line[i] = (line[i] + before[i]) & 255
        elif kind == 3:
            line[i] = (line[i] + (left + before[i]) // 2) & 255
        elif kind == 4:
            guess = left + before[i] - corner
            nearest = min((left, before[i], corner), key=lambda value: abs(guess - value))
            line[i] = (line[i] + nearest) & 255


def write_png(path, picture):
    """A picture of 8 bits a sample, each row as its differences from the one above."""
    raw, before = bytearray(), bytes(3 * len(picture[0]))
    for row in picture:
        line = bytes(sample for pixel in row for sample in pixel)
        raw += b"\x02" + bytes((a - b) & 255 for a, b in zip(line, before))
        before = line

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", len(picture[0]), len(picture), 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(raw), 9)) + chunk(b"IEND", b"")
    pathlib.Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + body)


def read_pfm(path):
    """A map; what is not finite is unknown."""
    with open(path, "rb") as file:
        file.readline()
        width, height = map(int, file.readline().split())
        little = float(file.readline()) < 0
        values = array.array("f", file.read(4 * width * height))
    if little != (sys.byteorder == "little"):
        values.byteswap()
    rows = [values[y * width : (y + 1) * width] for y in reversed(range(height))]
    return [[value if abs(value) < 1e9 else None for value in row] for row in rows]


def read_truth(path, scale):
    """A map from a PFM, in px, or from a PNG of which `scale` stands for 1 px and 0 is unknown."""
    if str(path).endswith(".pfm"):
        return read_pfm(path)
    return [[sample[0] / scale if sample[0] else None for sample in row] for row in read_png(path)]


def turbo(share):
    """The colours of the command's pictures: turbo without its dark ends (A. Mikhailov, in the polynomial of d3)."""
    t = 0.08 + min(max(share, 0.0), 1.0) * 0.89
    red = 34.61 + t * (1172.33 - t * (10793.56 - t * (33300.12 - t * (38394.49 - t * 14825.05))))
    green = 23.31 + t * (557.33 + t * (1225.33 - t * (3574.96 - t * (1073.77 + t * 707.56))))
    blue = 27.2 + t * (3211.1 - t * (15327.97 - t * (27814 - t * (22569.18 - t * 6838.66))))
    return tuple(min(max(round(value), 0), 255) for value in (red, green, blue))


def coloured(rows, last):
    """The picture of a map with the colours of 0 to `last` px; what is unknown is black."""
    return [[(0, 0, 0) if value is None else turbo(value / last) for value in row] for row in rows]


def crop(rows, x, y, width, height, factor):
    """A part, enlarged: each pixel becomes `factor` x `factor`."""
    part = [row[x : x + width] for row in rows[y : y + height]]
    return [[pixel for pixel in row for _ in range(factor)] for row in part for _ in range(factor)]


def beside(pictures, gap=4):
    """Pictures of one height in a row, with white between them."""
    white = [(255, 255, 255)] * gap
    rows = []
    for lines in zip(*pictures):
        row = list(lines[0])
        for line in lines[1:]:
            row += white + list(line)
        rows.append(row)
    return rows
