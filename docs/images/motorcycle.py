#!/usr/bin/env python3
"""Makes motorcycle.png, the README's picture: the left image of data/motorcycle beside the colour map of its disparities.

    cargo build --release
    python3 -m venv target/picture && target/picture/bin/pip install pillow
    target/picture/bin/python docs/images/motorcycle.py target/release/gpu-stereo
"""

import pathlib
import subprocess
import sys
import tempfile

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAIR = ROOT / "data" / "motorcycle"
SIZE = (494, 333)  # two thirds of 741 x 500: both halves together stay well under 500 KB


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        color = pathlib.Path(folder) / "color.png"
        command = [program, PAIR / "left.png", PAIR / "right.png", "--disp", "64", "--color", color]
        subprocess.run(command, check=True)
        halves = [Image.open(path).convert("RGB").resize(SIZE, Image.LANCZOS) for path in (PAIR / "left.png", color)]
    picture = Image.new("RGB", (2 * SIZE[0] + 4, SIZE[1]), "white")
    picture.paste(halves[0], (0, 0))
    picture.paste(halves[1], (SIZE[0] + 4, 0))
    picture.save(pathlib.Path(__file__).with_name("motorcycle.png"), optimize=True)


if __name__ == "__main__":
    main()
