"""A pair with a truth, made for docs/gallery.py: before a wall at 6 px with texture, a plate at 30 px without any, and one of stripes
that repeat every 8 px. Needs Python 3.8 alone.
"""

import array
import sys

import pixels

WIDTH, HEIGHT = 256, 108
WALL, PLATE = 6, 30
# Left, top, right and bottom of the plates in the left image.
FLAT, STRIPED = (40, 22, 108, 86), (152, 22, 220, 86)


def noise(x, y, seed):
    """Pseudorandom, 0 to 255."""
    h = (x * 374761393 + y * 668265263 + seed * 974634779) & 0xFFFFFFFF
    h = ((h ^ (h >> 13)) * 1274126177) & 0xFFFFFFFF
    return (h ^ (h >> 16)) & 255


def rough(x, y):
    """The wall: spots of two pixels, and finer ones."""
    return 60 + (noise(x // 2, y // 2, 1) + noise(x, y, 2)) // 4


def inside(box, x, y):
    return box[0] <= x < box[2] and box[1] <= y < box[3]


def sample(x, y, right):
    """Gray, and the disparity, of a pixel of the left or the right image."""
    place = x + PLATE if right else x
    if inside(FLAT, place, y):
        gray, disparity = 140, PLATE
    elif inside(STRIPED, place, y):
        gray, disparity = 70 + 120 * (place % 8 < 4), PLATE
    else:
        gray, disparity = rough(x + WALL if right else x, y), WALL
    return gray + noise(x, y, 5 + right) % 5 - 2, disparity


def write(folder):
    """left.png, right.png and disp_left.pfm."""
    for right, name in enumerate(("left", "right")):
        rows = [[(sample(x, y, right)[0],) * 3 for x in range(WIDTH)] for y in range(HEIGHT)]
        pixels.write_png(folder / f"{name}.png", rows)
    truth = array.array("f", (sample(x, y, 0)[1] for y in reversed(range(HEIGHT)) for x in range(WIDTH)))
    if sys.byteorder == "big":
        truth.byteswap()
    (folder / "disp_left.pfm").write_bytes(f"Pf\n{WIDTH} {HEIGHT}\n-1.0\n".encode() + truth.tobytes())
