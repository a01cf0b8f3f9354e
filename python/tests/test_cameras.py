"""Calibrations and rectification, beside those of the command."""

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_stereo

CAMCHAIN = Path(__file__).with_name("data") / "camchain.yaml"


@pytest.fixture(scope="module")
def pair(motorcycle: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Images of the calibrated size."""
    rows, columns = np.arange(480), np.minimum(np.arange(752), 740)
    left, right = (np.ascontiguousarray(image[rows][:, columns]) for image in motorcycle)
    return left, right


def save(path: Path, image: np.ndarray) -> Path:
    """As a PNM file."""
    rows, columns = image.shape[:2]
    kind = b"P6" if image.ndim == 3 else b"P5"
    path.write_bytes(kind + f"\n{columns} {rows}\n255\n".encode() + image.tobytes())
    return path


def test_what_is_read() -> None:
    rectified = gpu_stereo.read_calibration("data/motorcycle/calib.txt")
    assert not rectified.rectifies and "Middlebury" in rectified.kind
    camera = rectified.camera(741, 500)
    assert camera == gpu_stereo.Camera(camera.focal, camera.baseline, camera.cx, camera.cy, camera.doffs)
    assert camera != gpu_stereo.Camera(camera.focal, 1, camera.cx, camera.cy)
    assert eval(repr(camera), {"Camera": gpu_stereo.Camera}) == camera
    raw = gpu_stereo.read_calibration(CAMCHAIN, rectify=True)
    assert raw.rectifies
    assert abs(raw.camera(752, 480).baseline - 0.11) < 1e-3
    assert abs(gpu_stereo.read_calibration(CAMCHAIN, rectify=True, calib_scale=0.5).camera(376, 240).focal - raw.camera(752, 480).focal / 2) < 1e-6


def test_rectified_images_are_the_command_s(
    pair: tuple[np.ndarray, np.ndarray], command: Callable[..., Any], tmp_path: Path
) -> None:
    files = [save(tmp_path / name, image) for name, image in zip(("l.ppm", "r.ppm"), pair, strict=True)]
    (tmp_path / "out").mkdir()
    outputs = ["--rectified", f"{tmp_path / 'left.png'},{tmp_path / 'right.png'}", "-o", tmp_path / "map.npy", "--depth", tmp_path / "z.npy"]
    command(*files, "--disp", 64, "--backend", "cpu", "--rectify", CAMCHAIN, "--alpha", 0.5, *outputs)
    calibration = gpu_stereo.read_calibration(CAMCHAIN, rectify=True, alpha=0.5)
    left, right, camera = gpu_stereo.rectify(*pair, calibration)
    expected = gpu_stereo.read_pair(tmp_path / "left.png", tmp_path / "right.png")
    np.testing.assert_array_equal(left, expected[0])
    np.testing.assert_array_equal(right, expected[1])
    matched = gpu_stereo.match(*pair, 64, device="cpu", cameras=calibration)
    np.testing.assert_array_equal(matched.disparity, np.load(tmp_path / "map.npy"))
    np.testing.assert_array_equal(matched.depth, np.load(tmp_path / "z.npy"))
    assert matched.camera == camera


def test_kinds_of_images_stay(pair: tuple[np.ndarray, np.ndarray]) -> None:
    calibration = gpu_stereo.read_calibration(CAMCHAIN, rectify=True)
    colors = gpu_stereo.rectify(*pair, calibration)[0]
    gray = gpu_stereo.rectify(*(image[..., 0] for image in pair), calibration)[0]
    four = gpu_stereo.rectify(*(np.dstack([image, image[..., :1]]) for image in pair), calibration)[0]
    deep = gpu_stereo.rectify(*(image[..., 0].astype("uint16") for image in pair), calibration)[0]
    assert (colors.shape, gray.shape, four.shape) == ((480, 752, 3), (480, 752), (480, 752, 4))
    assert (colors.dtype, gray.dtype, deep.dtype) == ("uint8", "uint8", "uint16")
    np.testing.assert_array_equal(colors[..., 0], gray)
    np.testing.assert_array_equal(four[..., :3], colors)
    small = gpu_stereo.read_calibration(CAMCHAIN, rectify=True, rectified_size=(400, 300))
    assert gpu_stereo.rectify(*pair, small)[0].shape == (300, 400, 3)
    assert gpu_stereo.match(*pair, 32, "fast", "cpu", cameras=small).shape == (300, 400)
    with pytest.raises(gpu_stereo.InputError, match="read it with rectify=True"):
        gpu_stereo.rectify(*np.zeros((2, 500, 741), "uint8"), gpu_stereo.read_calibration("data/motorcycle/calib.txt"))


def test_cameras_one_above_the_other(
    motorcycle: tuple[np.ndarray, np.ndarray], command: Callable[..., Any], tmp_path: Path
) -> None:
    """A pair that lies on its side, the upper camera first: the map lies as the images do."""
    upper, lower = (np.ascontiguousarray(np.rot90(image, -1)) for image in motorcycle)
    vertical = CAMCHAIN.with_name("vertical.yaml")
    files = [save(tmp_path / name, image) for name, image in (("u.ppm", upper), ("l.ppm", lower))]
    command(*files, "--disp", 64, "--backend", "cpu", "--rectify", vertical, "-o", tmp_path / "map.npy", "--depth", tmp_path / "z.npy")
    calibration = gpu_stereo.read_calibration(vertical, rectify=True)
    found = gpu_stereo.match(upper, lower, 64, device="cpu", cameras=calibration)
    assert found.shape == (741, 500)
    np.testing.assert_array_equal(found.disparity, np.load(tmp_path / "map.npy"))
    np.testing.assert_array_equal(found.depth, np.load(tmp_path / "z.npy"))
    assert found.mask.mean() > 0.8
    automatic = gpu_stereo.match(upper, lower, "auto", device="cpu", cameras=calibration)
    assert automatic.mask.mean() > 0.8
    streamed = list(gpu_stereo.stream([(upper, lower)] * 2, 64, device="cpu", cameras=calibration))
    np.testing.assert_array_equal(streamed[1].raw, found.raw)


def test_cameras_are_pickled() -> None:
    camera = gpu_stereo.Camera(700.5, 0.12, 320, 240, 3)
    assert pickle.loads(pickle.dumps(camera)) == camera
