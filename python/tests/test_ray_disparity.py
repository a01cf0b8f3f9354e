"""examples/ray_disparity.py on two actors of this machine, one of which is killed: nothing lost, nothing twice.

    pip install "ray[data]" pytest; cargo build --release --bin gpu-stereo; pytest python/tests/test_ray_disparity.py
"""

from __future__ import annotations

import csv
import hashlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_stereo

pytest.importorskip("ray.data", reason="NOT TESTED: Ray is not installed (pip install 'ray[data]')")
import pyarrow.parquet as pq  # noqa: E402 - comes with Ray

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "ray_disparity.py"
PAIRS = 24


def command() -> str:
    """The built command."""
    named = os.environ.get("GPU_STEREO_BINARY")
    for path in [Path(named)] if named else [ROOT / "target" / kind / "gpu-stereo" for kind in ("release", "debug")]:
        if path.is_file():
            return str(path)
    pytest.skip("NOT TESTED: there is no gpu-stereo in target; build it, or name it by GPU_STEREO_BINARY")


def write_png(path: Path, image: Any) -> None:
    import struct
    import zlib

    height, width = image.shape[:2]
    lines = np.zeros((height, 1 + 3 * width), np.uint8)
    lines[:, 1:] = image.reshape(height, -1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(lines.tobytes(), 1)) + chunk(b"IEND", b""))


@pytest.fixture(scope="module")
def data(tmp_path_factory: Any) -> Path:
    """Parts of data/motorcycle in two sizes, a pair without its right image and one with a damaged one."""
    folder = tmp_path_factory.mktemp("pairs")
    motorcycle = ROOT / "data" / "motorcycle"
    left, right = gpu_stereo.read_pair(motorcycle / "left.png", motorcycle / "right.png")
    rows = []
    for number in range(PAIRS):
        y, width = 8 * number, 741 if number % 3 else 640
        for side, image in (("left", left), ("right", right)):
            write_png(folder / f"{side}{number}.png", image[y : y + 300, :width])
        rows.append([f"left{number}.png", f"right{number}.png", f"part{number % 2}/{number}"])
    (folder / "right5.png").unlink()
    (folder / "right6.png").write_bytes((folder / "right7.png").read_bytes()[:2000])
    with open(folder / "pairs.csv", "w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([["left", "right", "name"], *rows])
    return folder


def started(data: Path, out: Path, *more: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(EXAMPLE), str(data / "pairs.csv"), "-o", str(out), "--disp", "64", "--device", "cpu", "--block", "4",
         "--actors", "2", *more],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def rows(out: Path) -> list[dict[str, Any]]:
    return [row for path in sorted((out / "rows").glob("*.parquet")) for row in pq.read_table(path).to_pylist()]


def kill_one(out: Path, killed: list[int]) -> None:
    """Kills the process of a pair that is being computed, after some maps are there."""
    deadline = time.monotonic() + 300
    while time.monotonic() < deadline:
        if len(list(out.glob("*/*.png"))) >= 6:
            for note in (out / "begun").glob("*"):
                try:
                    lines = note.read_text(encoding="utf-8").split()
                    os.kill(int(lines[-1]), signal.SIGKILL)
                except (OSError, IndexError):
                    continue  # it was just finished
                killed.append(int(lines[-1]))
                return
        time.sleep(0.002)


def test_an_actor_that_is_killed_loses_nothing(data: Path, tmp_path: Path) -> None:
    expected = tmp_path / "expected"
    subprocess.run(
        [command(), "batch", str(data / "pairs.csv"), "-o", str(expected), "--disp", "64", "--backend", "cpu", "-q"],
        check=False, capture_output=True,
    )  # fmt: skip
    out = tmp_path / "maps"
    killed: list[int] = []
    process = started(data, out)
    watcher = threading.Thread(target=kill_one, args=(out, killed))
    watcher.start()
    said, complained = process.communicate(timeout=600)
    watcher.join()
    assert len(killed) == 1, complained
    assert process.returncode == 1, complained  # two pairs fail
    assert f"{PAIRS - 2} computed, 0 were there, 2 failed" in said.splitlines()

    found = rows(out)
    assert Counter(row["name"] for row in found) == Counter(f"part{number % 2}/{number}" for number in range(PAIRS))
    failed = {row["name"]: row["error"] for row in found if row["error"] is not None}
    assert set(failed) == {"part1/5", "part0/6"}
    assert "right5.png" in failed["part1/5"] and "right6.png" in failed["part0/6"]
    maps = sorted(str(path.relative_to(expected)) for path in expected.glob("*/*.png"))
    assert len(maps) == PAIRS - 2
    assert sorted(str(path.relative_to(out)) for path in out.glob("*/*.png")) == maps
    for name in maps:
        theirs, ours = (gpu_stereo.read_disparity(folder / name) for folder in (expected, out))
        assert np.array_equal(theirs, ours, equal_nan=True), name
        assert np.isfinite(ours).mean() > 0.5
    assert len(list(out.rglob(".begun-*"))) <= 1  # what the killed process was writing
    assert list((out / "begun").glob("*")) == []

    # Again: nothing is computed.
    before = {path: path.stat().st_mtime_ns for path in out.glob("*/*.png")}
    process = started(data, out)
    said, _ = process.communicate(timeout=600)
    assert f"0 computed, {PAIRS} were there, 0 failed" in said.splitlines()
    assert {path: path.stat().st_mtime_ns for path in out.glob("*/*.png")} == before


def test_maps_in_parquet(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "maps"
    process = started(data, out, "--format", "parquet", "--option", "uniqueness=10")
    _, complained = process.communicate(timeout=600)
    assert process.returncode == 1, complained
    found = [row for row in rows(out) if row["error"] is None]
    assert len(found) == PAIRS - 2
    path = tmp_path / "map.png"
    path.write_bytes(found[0]["png"])
    left, right = gpu_stereo.read_pair(found[0]["left"], found[0]["right"])
    same = gpu_stereo.match(left, right, disparities=64, device="cpu", preset="balanced", uniqueness=10)
    assert np.array_equal(gpu_stereo.read_disparity(path), same.disparity, equal_nan=True)


def test_a_pair_that_ends_the_process_is_given_up(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "maps"
    note = out / "begun" / hashlib.sha256(b"part0/2").hexdigest()[:32]
    note.parent.mkdir(parents=True)
    note.write_text("1\n2\n3\n")
    started(data, out).communicate(timeout=600)
    assert {row["name"]: row["error"] for row in rows(out)}["part0/2"].startswith("the process ended 3 times")
    assert not (out / "part0" / "2.png").exists()
    said, _ = started(data, out, "--retry").communicate(timeout=600)
    assert f"1 computed, {PAIRS - 3} were there, 2 failed" in said.splitlines()
    assert (out / "part0" / "2.png").exists()


def test_other_settings_are_refused(data: Path, tmp_path: Path) -> None:
    out = tmp_path / "maps"
    out.mkdir()
    (out / "ray_disparity.json").write_text("{}")
    process = started(data, out)
    _, complained = process.communicate(timeout=600)
    assert process.returncode == 2
    assert "made with other settings" in complained
