#!/usr/bin/env python3
"""Rewrites data/motorcycle from the scikit-image wheel on the Python package index.

    python3 data/fetch_motorcycle.py

Needs Python 3.8 or later with pip, and nothing else. The pair is copied byte for byte; the ground truth is rewritten
from NumPy's archive to PFM, value for value; calib.txt is written here in Middlebury's form from the figures in the
docstring of skimage.data.stereo_motorcycle. Every file is checked before it replaces what is there.
"""

import ast
import hashlib
import io
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile

VERSION = "0.17.2"  # ships the three files, as 0.16 to 0.20 do; its wheel is the smallest of those

SHA256 = {
    "left.png": "db18e9c4157617403c3537a6ba355dfeafe9a7eabb6b9b94cb33f6525dd49179",
    "right.png": "5fc913ae870e42a4b662314bc904d1786bcad8e2f0b9b67dba5a229406357797",
    "disp_left.pfm": "b82d2896eb0f10433c69beb97d16d9ab07fc34db155eb67a6fcbb4af2b3e048b",
    "calib.txt": "41987b72b1021df43cd003476d0d680093ce75fd6b9655df41fe6bbb6d0bccc0",
}

# Z = baseline * f / (disparity + doffs), in mm. ndisp is Middlebury's 280 at full size, divided by 4.
CALIB = """\
cam0=[994.978 0 311.193; 0 994.978 254.877; 0 0 1]
cam1=[994.978 0 342.279; 0 994.978 254.877; 0 0 1]
doffs=31.086
baseline=193.001
width=741
height=500
ndisp=70
"""


def download_wheel(folder):
    """The wheel, whatever this machine is: only its data files are read."""
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps",
               "--only-binary", ":all:", "--implementation", "cp", "--python-version", "3.8", "--abi", "cp38",
               "--platform", "manylinux1_x86_64", "--dest", folder, f"scikit-image=={VERSION}"]
    if subprocess.run(command).returncode != 0:
        sys.exit(f"fetch_motorcycle: pip could not download scikit-image {VERSION}; is a package index reachable?")
    (wheel,) = pathlib.Path(folder).glob("scikit_image-*.whl")
    return zipfile.ZipFile(wheel)


def pfm_of_npz(npz):
    """The archive's only array, f32 and row by row from the top, as a little-endian PFM: row by row from the bottom."""
    npy = zipfile.ZipFile(io.BytesIO(npz)).read("arr_0.npy")
    (header_len,) = struct.unpack("<H", npy[8:10])
    header = ast.literal_eval(npy[10:10 + header_len].decode("latin-1"))
    assert header["descr"] == "<f4" and not header["fortran_order"], header
    height, width = header["shape"]
    samples = npy[10 + header_len:]
    rows = [samples[4 * width * y:4 * width * (y + 1)] for y in range(height)]
    return f"Pf\n{width} {height}\n-1.0\n".encode() + b"".join(reversed(rows))


def main():
    with tempfile.TemporaryDirectory() as folder, download_wheel(folder) as wheel:
        shipped = {name: wheel.read(f"skimage/data/motorcycle_{name}") for name in ("left.png", "right.png", "disp.npz")}
    files = {
        "left.png": shipped["left.png"],
        "right.png": shipped["right.png"],
        "disp_left.pfm": pfm_of_npz(shipped["disp.npz"]),
        "calib.txt": CALIB.encode(),
    }
    for name, data in files.items():
        found = hashlib.sha256(data).hexdigest()
        if found != SHA256[name]:
            sys.exit(f"fetch_motorcycle: {name} has sha256 {found}, expected {SHA256[name]}; nothing was written")
    target = pathlib.Path(__file__).resolve().parent / "motorcycle"
    target.mkdir(exist_ok=True)
    for name, data in files.items():
        (target / name).write_bytes(data)
    print(f"{len(files)} files from scikit-image {VERSION} written to {target}, sha256 as expected")


if __name__ == "__main__":
    main()
