"""examples/rerun_pairs.py: the recording of a pair has what it tells of."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rerun", reason="NOT TESTED: Rerun is not installed (pip install rerun-sdk)")

ROOT = Path(__file__).resolve().parents[2]
MOTORCYCLE = ROOT / "data" / "motorcycle"
IMAGES = [str(MOTORCYCLE / "left.png"), str(MOTORCYCLE / "right.png")]


def record(folder: Path, *arguments: str) -> str:
    """What `rerun rrd print` tells of a recording."""
    saved = folder / "pair.rrd"
    script = [sys.executable, str(ROOT / "examples" / "rerun_pairs.py"), *arguments, "--save", str(saved)]
    subprocess.run(script, check=True, capture_output=True)
    told = subprocess.run([sys.executable, "-m", "rerun", "rrd", "print", str(saved)], check=True, capture_output=True, text=True)
    return told.stdout + told.stderr


def test_with_cameras_there_are_depths_and_points(tmp_path: Path) -> None:
    told = record(tmp_path, *IMAGES, "--calib", str(MOTORCYCLE / "calib.txt"))
    for entity in ("/disparity", "/world/left/image", "/world/right/image", "/world/left/depth", "/world/points"):
        assert entity in told, f"{entity} is missing:\n{told}"


def test_without_cameras_there_are_disparities_alone(tmp_path: Path) -> None:
    told = record(tmp_path, *IMAGES)
    assert "/disparity" in told and "/world/points" not in told and "/world/left/depth" not in told


def test_sides_of_different_length_are_refused(tmp_path: Path) -> None:
    for side, count in (("left", 2), ("right", 1)):
        (tmp_path / side).mkdir()
        for number in range(count):
            (tmp_path / side / f"{number}.png").write_bytes((MOTORCYCLE / f"{side}.png").read_bytes())
    script = [sys.executable, str(ROOT / "examples" / "rerun_pairs.py"), str(tmp_path / "left"), str(tmp_path / "right")]
    refused = subprocess.run(script, check=False, capture_output=True, text=True)
    assert refused.returncode == 1 and "has 2 files" in refused.stderr, refused.stderr
