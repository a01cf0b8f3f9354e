"""What the tests share. They test the package that is installed, from any folder."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_stereo

ROOT = Path(__file__).resolve().parents[2]
MOTORCYCLE = ROOT / "data" / "motorcycle"


def not_tested(why: str) -> None:
    """Skips a test, and says so where it is seen."""
    print(f"NOT TESTED: {why}")
    pytest.skip(f"NOT TESTED: {why}")


@pytest.fixture(autouse=True)
def _in_root(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


@pytest.fixture(scope="session")
def motorcycle() -> tuple[np.ndarray, np.ndarray]:
    """The pair of data/motorcycle, in colours."""
    return gpu_stereo.read_pair(MOTORCYCLE / "left.png", MOTORCYCLE / "right.png")


@pytest.fixture(scope="session")
def small(motorcycle: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """A part of it in gray, 160 x 96, whose disparities are within 0 to 63."""
    left, right = (np.ascontiguousarray(image[200:296, 300:460, 1]) for image in motorcycle)
    return left, right


@pytest.fixture(scope="session")
def command() -> Callable[..., Any]:
    """Runs the command, which must be built: ``command(*args, folder=..)`` returns what it prints as JSON."""
    given = os.environ.get("GPU_STEREO_COMMAND")
    found = [Path(given)] if given else [ROOT / "target" / kind / "gpu-stereo" for kind in ("debug", "release")]
    program = next((path for path in found if path.exists()), None)
    if given and program is None:
        pytest.fail(f"GPU_STEREO_COMMAND is {given!r}, where no file is")
    if program is None:
        not_tested("the command is not built: cargo build, or GPU_STEREO_COMMAND=PATH")

    def run(*args: object, folder: Path = ROOT) -> Any:
        done = subprocess.run([program, *map(str, args), "--json"], cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return run
