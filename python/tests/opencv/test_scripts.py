"""Three scripts of the kind that everybody starts from, with either import line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .conftest import ROOT

SCRIPTS = Path(__file__).parent / "scripts"


def run(name: str, module: str, folder: Path) -> Path:
    text = (SCRIPTS / f"{name}.py").read_text(encoding="utf-8")
    assert text.count("import cv2 as cv\n") == 1
    out = folder / module
    out.mkdir()
    script = out / f"{name}.py"
    script.write_text(text.replace("import cv2 as cv\n", f"import {module} as cv\n"), encoding="utf-8")
    pair = [str(ROOT / "data" / "motorcycle" / f"{side}.png") for side in ("left", "right")]
    done = subprocess.run([sys.executable, str(script), *pair, str(out)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out


def both(name: str, folder: Path) -> tuple[Path, Path]:
    theirs, ours = run(name, "cv2", folder), run(name, "gpu_stereo.cv", folder)
    assert sorted(path.name for path in theirs.iterdir()) == sorted(path.name for path in ours.iterdir())
    return theirs, ours


def test_a_point_cloud(cv2: Any, tmp_path: Path) -> None:
    theirs, ours = both("point_cloud", tmp_path)
    counts = [int((out / "points.ply").read_text().split("element vertex ")[1].split()[0]) for out in (theirs, ours)]
    assert counts[1] == pytest.approx(counts[0], rel=0.05)
    maps = [np.load(out / "disparity.npy") for out in (theirs, ours)]
    valid = (maps[0] >= 0) & (maps[1] >= 0)
    assert (np.abs(maps[0] - maps[1])[valid] <= 1).mean() > 0.95


def test_a_tuner(cv2: Any, tmp_path: Path) -> None:
    theirs, ours = both("tuner", tmp_path)
    for number in range(5):
        maps = [np.load(out / f"tuned{number}.npy") for out in (theirs, ours)]
        assert (maps[0] == maps[1]).mean() > 0.99, number


def test_a_filter_by_weighted_least_squares(ximgproc: Any, tmp_path: Path) -> None:
    theirs, ours = both("wls_demo", tmp_path)
    maps = [np.load(out / "filtered.npy").astype(int) for out in (theirs, ours)]
    assert (np.abs(maps[0] - maps[1]) <= 16).mean() > 0.9
