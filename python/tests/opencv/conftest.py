"""OpenCV, where it is installed, and pairs to compare with."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_stereo

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="session")
def cv2() -> Any:
    """OpenCV 5 itself."""
    try:
        import cv2
    except ImportError:
        pytest.skip("NOT TESTED: OpenCV is not installed (pip install opencv-contrib-python-headless)")
    if not cv2.__version__.startswith("5."):
        pytest.skip(f"NOT TESTED: OpenCV is {cv2.__version__}; the comparisons are with 5")
    return cv2


@pytest.fixture(scope="session")
def ximgproc(cv2: Any) -> Any:
    """OpenCV's contributed filters."""
    if not hasattr(cv2, "ximgproc"):
        pytest.skip("NOT TESTED: OpenCV has no ximgproc (pip install opencv-contrib-python-headless)")
    return cv2.ximgproc


@pytest.fixture(scope="session")
def pair() -> tuple[Any, Any]:
    """The middle of data/motorcycle, in blue, green and red."""
    folder = ROOT / "data" / "motorcycle"
    left, right = gpu_stereo.read_pair(folder / "left.png", folder / "right.png")
    return tuple(np.ascontiguousarray(image[150:350, 200:600, ::-1]) for image in (left, right))


@pytest.fixture(scope="session")
def gray_pair(pair: tuple[Any, Any]) -> tuple[Any, Any]:
    """The same in gray."""
    return tuple(np.rint(image @ np.array([0.114, 0.587, 0.299])).astype(np.uint8) for image in pair)


@pytest.fixture(autouse=True)
def quiet_penalties() -> Any:
    """That a small P1 is rounded is tested by itself."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="P[12] = ", category=UserWarning)
        yield
