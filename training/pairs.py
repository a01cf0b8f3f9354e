"""Stereo pairs with their truth: those of a collection with a MANIFEST.json, and those that the generator made."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image

COLLECTION = Path(__file__).resolve().parent.parent.parent / "shared" / "data"


@dataclass
class Pair:
    """Luma of both sides (uint8), the disparity of the left one (float32, NaN where unknown) and where the right one sees it."""

    name: str
    left: np.ndarray
    right: np.ndarray
    truth: np.ndarray
    visible: np.ndarray
    disparities: int


def luma(path):
    """Luma of 8 bits as the library reads it."""
    samples = np.asarray(Image.open(path))
    if samples.ndim == 2:
        return samples
    r, g, b = (samples[:, :, i].astype(np.uint32) for i in range(3))
    return ((9798 * r + 19235 * g + 3735 * b + 16384) >> 15).astype(np.uint8)


def read_pfm(path):
    """The values of a PFM file with one channel."""
    with open(path, "rb") as file:
        fields = [file.readline() for _ in range(3)]
        width, height = map(int, fields[1].split())
        kind = "<f4" if float(fields[2]) < 0 else ">f4"
        return np.frombuffer(file.read(), kind).reshape(height, width)[::-1].astype(np.float32)


def collection(only=None, root=COLLECTION):
    """The pairs of a collection with a truth, those whose set/scene contains one of `only`."""
    for entry in json.loads((root / "MANIFEST.json").read_text()):
        name = f"{entry['set']}/{entry['scene']}"
        if not entry["gt"] or only and not any(part in name for part in only):
            continue
        path = root / entry["gt"]
        samples = read_pfm(path) if path.suffix == ".pfm" else np.asarray(Image.open(path)).astype(np.float32)
        truth = samples / entry["gt_scale"]
        truth[(samples == 0) | ~np.isfinite(samples)] = np.nan
        masks = entry["mask"] or {}
        visible = np.isfinite(truth)
        if "nonocc" in masks:
            visible &= np.asarray(Image.open(root / masks["nonocc"])) > 0
        disparities = 128 if "kitti" in name else -(-int(entry["max_disp"] + 1) // 16) * 16
        yield Pair(name, luma(root / entry["left"]), luma(root / entry["right"]), truth, visible, disparities)


def generated(directory, limit=None):
    """The pairs of a directory that the generator wrote."""
    for scene in sorted(p for p in Path(directory).iterdir() if (p / "disp_left.pfm").exists())[:limit]:
        truth = read_pfm(scene / "disp_left.pfm").copy()
        truth[~np.isfinite(truth)] = np.nan
        visible = (np.asarray(Image.open(scene / "nonocc_left.png")) > 0) & np.isfinite(truth)
        disparities = int(re.search(r"ndisp=(\d+)", (scene / "calib.txt").read_text()).group(1))
        yield Pair(scene.name, luma(scene / "left.png"), luma(scene / "right.png"), truth, visible, disparities)
