"""What is wrong is refused by an exception that says what was given, what is allowed and what to do."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_stereo

GRAY = np.zeros((8, 40), "uint8")


class OnDevice:
    def __dlpack__(self, **_: Any) -> Any:
        raise AssertionError("it is not asked for")

    def __dlpack_device__(self) -> tuple[int, int]:
        return (2, 0)


@pytest.mark.parametrize(
    ("left", "right", "text"),
    [
        (GRAY, GRAY[1:], "left is 40x8 and right 40x7, but a rectified pair has one size"),
        (GRAY.astype("float32"), GRAY, "left has samples of float32, but must have uint8 or uint16"),
        (GRAY, GRAY.astype("int16"), "right has samples of int16"),
        (GRAY, GRAY.astype(bool), "right has samples of bool"),
        (GRAY.astype(complex), GRAY, "left has samples of complex128"),
        (GRAY.astype(object), GRAY, "left has samples of object"),
        (GRAY[0], GRAY, r"left has the shape \(40,\), but must have \(rows, columns\)"),
        (GRAY[np.newaxis], GRAY, r"transpose\(1, 2, 0\)"),
        (GRAY[..., np.newaxis, np.newaxis], GRAY, r"left has the shape \(8, 40, 1, 1\)"),
        (np.zeros((8, 40, 2), "uint8"), GRAY, r"left has the shape \(8, 40, 2\)"),
        (GRAY[:0], GRAY[:0], "40x0"),
        (GRAY[:, :0], GRAY[:, :0], "0x8"),
        ([[1, 2], [3, 4]], GRAY, "left is of the type list, but must be an array"),
        (None, GRAY, "left is of the type NoneType"),
        ("left.png", GRAY, "left is of the type str"),
        (np.ma.masked_array(GRAY), GRAY, "left is a masked array"),
        (OnDevice(), GRAY, r"left lies on a device \(DLPack's type 2\)"),
        (np.zeros((8, 40), [("a", "u1")]), GRAY, "left has samples of"),
        (np.array("text"), GRAY, "left has samples of"),
    ],
)
def test_images(left: Any, right: Any, text: str) -> None:
    with pytest.raises(gpu_stereo.InputError, match=text):
        gpu_stereo.match(left, right, 16, device="cpu")


def test_huge_images_are_refused_before_they_are_copied() -> None:
    huge = np.broadcast_to(np.uint8(0), (60_000, 60_000))  # a byte of memory
    with pytest.raises(gpu_stereo.OutOfMemoryError, match="of memory, but"):
        gpu_stereo.match(huge, huge, 64, device="cpu")
    wider = np.broadcast_to(np.uint8(0), (1, 2**33))
    with pytest.raises(gpu_stereo.InputError, match="too large"):
        gpu_stereo.match(wider, wider, 64, device="cpu")
    matcher = gpu_stereo.StereoMatcher(40, 8, disparities=16, device="cpu")
    with pytest.raises(gpu_stereo.InputError, match="the images are 60000x60000, but the matcher was made for 40x8"):
        matcher.compute(huge, huge)


@pytest.mark.parametrize(
    ("keywords", "text"),
    [
        ({"disparities": 0}, "disparities is 0, but must be from 1 to"),
        ({"disparities": -5}, "disparities is -5, but must be"),
        ({"disparities": "many"}, "disparities is many, but must be a whole number"),
        ({"disparities": 16.5}, "disparities is 16.5, but must be a whole number"),
        ({"disparities": float("nan")}, "disparities is NaN, but must be"),
        ({"disparities": float("inf")}, "disparities is inf, but must be"),
        ({"disparities": 10**30}, "disparities is 1000000000000000000000000000000, but must be"),
        ({"disparities": []}, "disparities is of the type list, but must be a number"),
        ({"preset": "best"}, "preset is best, but must be one of classic, fast, balanced, strict, dense, accurate"),
        ({"cost": "zncc"}, "cost is zncc, but must be one of sad"),
        ({"p2": 500}, "p2 is 500, but must be from p1 to 127"),
        ({"p1": True}, "p1 is on, but must be a whole number"),
        ({"lr_check": float("nan")}, "lr_check is NaN, but must be a whole number or off"),
        ({"block": 4}, "block is 4, but must be"),
        ({"wls_sigma": float("nan")}, "wls_sigma is NaN, but must be"),
        ({"nonsense": 1}, '"nonsense" is no keyword'),
        ({"disp": 16}, "disp is given by the argument disparities here"),
        ({"lr-check": "\0"}, "lr_check is .*, but must be"),
        ({"channels": "gbr"}, 'channels is "gbr", but must be "rgb" or "bgr"'),
        ({"bits": 7}, "bits is 7, but 8 to 16 or auto is needed"),
        ({"confidence": "yes"}, "confidence is yes, but must be True or False"),
        ({"cameras": 3}, "cameras is of the type int, but must be a gpu_stereo.Camera"),
        ({"mask": GRAY[1:]}, "a mask is 40x7, but the images are 40x8"),
        ({"mask": (GRAY,)}, "mask must be an array for both images, or two"),
        ({"mask": GRAY.astype("float32")}, "mask has elements of float32, but must have bool or uint8"),
        ({"method": "psmnet"}, "needs the weights of a network; give weights"),
        ({"device": 1.5}, "device is 1.5, but must be"),
    ],
)
def test_keywords(keywords: dict[str, Any], text: str) -> None:
    with pytest.raises(gpu_stereo.InputError, match=text):
        gpu_stereo.match(GRAY, GRAY, **{"disparities": 16, "device": "cpu", **keywords})


@pytest.mark.parametrize("device", ["no such adapter", 4_000_000_000, ""])
def test_devices(device: Any) -> None:
    with pytest.raises(gpu_stereo.Error, match=f'device is "{device}", but must be'):
        gpu_stereo.StereoMatcher(40, 8, device=device)


@pytest.mark.parametrize(("width", "height"), [(0, 8), (-1, 8), (40, 0), (2**40, 8)])
def test_sizes(width: int, height: int) -> None:
    with pytest.raises(gpu_stereo.Error, match="but must be"):
        gpu_stereo.StereoMatcher(width, height, device="cpu")


def test_exceptions_are_those_that_python_has_for_it() -> None:
    assert issubclass(gpu_stereo.InputError, ValueError)
    assert issubclass(gpu_stereo.FileError, OSError)
    assert issubclass(gpu_stereo.DeviceError, RuntimeError)
    assert issubclass(gpu_stereo.OutOfMemoryError, MemoryError)
    for name in ("InputError", "FileError", "DeviceError", "OutOfMemoryError"):
        assert issubclass(getattr(gpu_stereo, name), gpu_stereo.Error)
        assert getattr(gpu_stereo, name).__module__ == "gpu_stereo"


def test_files(tmp_path: Path) -> None:
    with pytest.raises(gpu_stereo.FileError, match='"none.png" does not exist'):
        gpu_stereo.read_pair("none.png", "other.png")
    with pytest.raises(gpu_stereo.InputError, match="split is for one picture"):
        gpu_stereo.read_pair("a.png", "b.png", split="sbs")
    with pytest.raises(gpu_stereo.InputError, match='split is "lr", but must be one of sbs'):
        gpu_stereo.read_pair("a.png", split="lr")  # type: ignore[arg-type]
    with pytest.raises(gpu_stereo.FileError, match="does not exist"):
        gpu_stereo.read_disparity("none.pfm")
    with pytest.raises(gpu_stereo.FileError, match="but gray values are needed"):
        gpu_stereo.read_disparity("data/motorcycle/left.png")
    (tmp_path / "map.pgm").write_bytes(b"P5\n2 2\n255\n1234")
    with pytest.raises(gpu_stereo.FileError, match="(?<!-)scale"):
        gpu_stereo.read_disparity(tmp_path / "map.pgm")
    with pytest.raises(gpu_stereo.FileError, match="\"none.txt\" cannot be read"):
        gpu_stereo.read_calibration("none.txt")
    with pytest.raises(gpu_stereo.InputError, match='calib_unit is "km", but must be one of m, cm, mm'):
        gpu_stereo.read_calibration("data/motorcycle/calib.txt", calib_unit="km")  # type: ignore[arg-type]
    with pytest.raises(gpu_stereo.Error, match="alpha goes with rectify"):
        gpu_stereo.read_calibration("data/motorcycle/calib.txt", alpha=0.5)
    calibration = gpu_stereo.read_calibration("data/motorcycle/calib.txt")
    with pytest.raises(gpu_stereo.InputError, match="741x500.*calib_scale"):
        calibration.camera(1482, 1000)
    with pytest.raises(gpu_stereo.InputError, match="baseline is -1, but must be from"):
        gpu_stereo.Camera(700, -1, 0, 0)
    with pytest.raises(gpu_stereo.InputError, match="focal is NaN, but must be from"):
        gpu_stereo.Camera(float("nan"), 0.1, 0, 0)
