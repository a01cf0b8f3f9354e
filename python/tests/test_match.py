"""Pairs are matched as the command matches them, however their images lie in memory."""

import array
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import MOTORCYCLE

import gpu_stereo

Pair = tuple[np.ndarray, np.ndarray]
CPU: dict[str, Any] = {"device": "cpu"}


def same(a: gpu_stereo.Matched, b: gpu_stereo.Matched) -> bool:
    return bool((a.raw == b.raw).all())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, []),
        ({"preset": "dense"}, ["--preset", "dense"]),
        ({"method": "bm", "block": 9, "texture": 10, "lr_check": False}, "--method bm --block 9 --texture 10 --lr-check off".split()),
        (
            {"cost": "sad", "color_cost": True, "min_disp": 3, "paths": 8, "wls_sigma": 2.5},
            "--cost sad --color-cost on --min-disp 3 --paths 8 --wls-sigma 2.5".split(),
        ),
    ],
)
def test_maps_are_the_command_s(
    motorcycle: Pair, command: Callable[..., Any], tmp_path: Path, options: dict[str, Any], words: list[str]
) -> None:
    files = [MOTORCYCLE / "left.png", MOTORCYCLE / "right.png"]
    command(*files, "--disp", 48, "--backend", "cpu", "-o", tmp_path / "map.npy", *words)
    matched = gpu_stereo.match(*motorcycle, 48, **CPU, **options)
    np.testing.assert_array_equal(matched.disparity, np.load(tmp_path / "map.npy"))
    # As OpenCV would have read the files.
    swapped = [image[..., ::-1] for image in motorcycle]
    assert same(gpu_stereo.match(*swapped, 48, channels="bgr", **CPU, **options), matched)
    if "color_cost" in options:
        assert not same(gpu_stereo.match(*swapped, 48, **CPU, **options), matched)


def test_all_other_maps_are_the_command_s(motorcycle: Pair, command: Callable[..., Any], tmp_path: Path) -> None:
    files = [MOTORCYCLE / "left.png", MOTORCYCLE / "right.png", "--calib", MOTORCYCLE / "calib.txt"]
    outputs = ["--right", tmp_path / "right.npy", "--depth", tmp_path / "depth.npy", "-o", tmp_path / "map.npy"]
    told = command(*files, "--disp", "auto", "--backend", "cpu", *outputs)
    cameras = gpu_stereo.read_calibration(MOTORCYCLE / "calib.txt")
    matched = gpu_stereo.match(*motorcycle, "auto", right_map=True, confidence=True, cameras=cameras, **CPU)
    assert matched.search_range == (told["min_disparity"], told["disparities"])
    np.testing.assert_array_equal(matched.right, np.load(tmp_path / "right.npy"))
    np.testing.assert_array_equal(matched.depth, np.load(tmp_path / "depth.npy"))
    assert set(np.unique(matched.confidence[~matched.mask])) == {0}
    assert matched.confidence[matched.mask].min() >= 1

    camera = matched.camera
    assert camera == cameras.camera(741, 500)
    z = camera.focal * camera.baseline / (matched.disparity + camera.doffs)
    np.testing.assert_allclose(matched.depth, z, rtol=1e-5)
    points = matched.points()
    y, x = np.nonzero(~np.isnan(matched.depth))
    z = matched.depth[y, x]
    expected = np.stack([(x - camera.cx) * z / camera.focal, (y - camera.cy) * z / camera.focal, z], 1)
    np.testing.assert_allclose(points, expected, rtol=1e-4, atol=1e-5)


def test_what_a_result_holds(small: Pair) -> None:
    matched = gpu_stereo.match(*small, 64, timings=True, **CPU)
    assert (matched.disparity.dtype, matched.raw.dtype, matched.mask.dtype) == ("float32", "int16", "bool")
    assert matched.shape == matched.disparity.shape == small[0].shape
    assert matched.mask.any() and not matched.mask.all()
    np.testing.assert_array_equal(np.isnan(matched.disparity), ~matched.mask)
    np.testing.assert_array_equal(matched.raw == -32768, ~matched.mask)
    np.testing.assert_array_equal(matched.disparity[matched.mask] * 16, matched.raw[matched.mask])
    assert matched.disparity is matched.disparity
    assert matched.timings and all(time >= 0 for time in matched.timings.values())
    for name in ("confidence", "right", "depth", "camera"):
        assert not hasattr(matched, name)
    with pytest.raises(AttributeError, match="match the pair with confidence=True"):
        _ = matched.confidence
    with pytest.raises(AttributeError, match="cameras"):
        matched.points()
    # DLPack shows the same memory.
    shown = np.from_dlpack(matched.disparity)
    assert np.shares_memory(shown, matched.disparity)


class DLPack:
    """What offers DLPack alone, as arrays of other libraries do."""

    def __init__(self, values: np.ndarray, kind: int | None = None) -> None:
        self.values, self.kind = values, kind

    def __dlpack__(self, **keywords: Any) -> Any:
        return self.values.__dlpack__(**keywords)

    def __dlpack_device__(self) -> tuple[int, int]:
        return self.values.__dlpack_device__() if self.kind is None else (self.kind, 0)


class Interface:
    """What offers __array_interface__ alone, as Pillow's images do."""

    def __init__(self, values: np.ndarray) -> None:
        self.values = values
        self.__array_interface__ = values.__array_interface__


def unaligned(image: np.ndarray) -> np.ndarray:
    room = np.zeros(image.nbytes + 1, "uint8")
    view = room[1:].view(image.dtype).reshape(image.shape)
    view[...] = image
    return view


LAYOUTS: dict[str, Callable[[np.ndarray], Any]] = {
    "part of a wider frame": lambda image: np.hstack([image, image])[:, : image.shape[1]],
    "every second row and column": lambda image: np.repeat(np.repeat(image, 2, 0), 2, 1)[::2, ::2],
    "backwards": lambda image: np.ascontiguousarray(image[::-1, ::-1])[::-1, ::-1],
    "Fortran": np.asfortranarray,
    "read-only": lambda image: np.frombuffer(image.tobytes(), image.dtype).reshape(image.shape),
    "other bytes first": lambda image: image.astype(image.dtype.newbyteorder()),
    "unaligned": unaligned,
    "DLPack": DLPack,
    "pinned": lambda image: DLPack(image, 3),
    "buffer": memoryview,
    "__array_interface__": Interface,
    "matrix of a subclass": lambda image: image.view(type("Sub", (np.ndarray,), {})),
    "one sample": lambda image: image[..., np.newaxis],
    "three samples": lambda image: np.stack([image] * 3, 2),
    "planes of colours": lambda image: np.stack([image] * 3, 0).transpose(1, 2, 0),
    "four samples": lambda image: np.stack([image, image, image, image * 0], 2),
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_layouts_in_memory_change_nothing(small: Pair, layout: str, dtype: str) -> None:
    pair = [image.astype(dtype) * (1 if dtype == "uint8" else 257) for image in small]
    expected = gpu_stereo.match(*pair, 64, **CPU)
    assert same(gpu_stereo.match(*map(LAYOUTS[layout], pair), 64, **CPU), expected)
    left, right = LAYOUTS[layout](pair[0]), pair[1]
    assert same(gpu_stereo.match(left, right, 64, **CPU), expected), "only one of them"


def test_a_flat_buffer_is_no_image(small: Pair) -> None:
    flat = array.array("B", small[0].tobytes())
    with pytest.raises(gpu_stereo.InputError, match=r"left has the shape \(15360,\), but must have \(rows, columns\)"):
        gpu_stereo.match(flat, flat, 16)


def test_bits_are_stretched_as_the_command_does(small: Pair) -> None:
    ten = [image.astype("uint16") << 2 for image in small]
    full = [np.round(image / 1023 * 65535).astype("uint16") for image in ten]
    expected = gpu_stereo.match(*full, 64, bits=16, **CPU)
    assert same(gpu_stereo.match(*ten, 64, **CPU), expected)
    assert same(gpu_stereo.match(*ten, 64, bits=10, **CPU), expected)
    with pytest.raises(gpu_stereo.InputError, match="but bits is 8; give bits 10 or more"):
        gpu_stereo.match(*ten, 64, bits=8, **CPU)


def test_masks(small: Pair) -> None:
    has = np.ones(small[0].shape, bool)
    has[:, 60:100] = False
    left = gpu_stereo.match(*small, 16, mask=(has, None), **CPU)
    assert not left.mask[:, 60:100].any() and left.mask[:, 110:].any()
    right = gpu_stereo.match(*small, 16, mask=(None, has), **CPU)
    x = np.arange(right.shape[1]) - np.nan_to_num(right.disparity, nan=1e6)
    assert not ((x >= 60.5) & (x <= 98.5)).any()
    both = gpu_stereo.match(*small, 16, mask=has.astype("uint8") * 255, **CPU)
    assert not (both.mask & ~left.mask & ~right.mask).any()
    with pytest.raises(gpu_stereo.InputError, match="a mask is 159x96, but the images are 160x96"):
        gpu_stereo.match(*small, 16, mask=has[:, 1:], **CPU)


def test_values_of_options(small: Pair) -> None:
    plain = gpu_stereo.match(*small, 64, **CPU)
    for options in [{"lr_check": None}, {"p2": np.int64(90)}, {"p2": "90"}, {"p2": 90.0}, {"adaptive_p2": True}, {"adaptive_p2": "on"}]:
        assert same(gpu_stereo.match(*small, 64, **CPU, **options), plain), options
    off = gpu_stereo.match(*small, 64, lr_check=False, **CPU)
    assert not same(off, plain) and same(off, gpu_stereo.match(*small, 64, lr_check="off", **CPU))
    matcher = gpu_stereo.StereoMatcher(160, 96, "strict", paths=8, **CPU)
    assert (matcher.settings["paths"], matcher.settings["uniqueness"], matcher.settings["disparities"]) == ("8", "10", "64")
    assert (matcher.width, matcher.height) == (160, 96)
    assert matcher.device.startswith("CPU with")
    assert "160x96" in repr(matcher)


def test_every_option_of_the_table_is_taken() -> None:
    matcher = gpu_stereo.StereoMatcher(40, 20, disparities=16, **CPU)
    options = gpu_stereo.options()
    assert {option.name for option in options} == set(matcher.settings) - {"disparities"}
    given = {option.name: matcher.settings[option.name] for option in options}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert gpu_stereo.StereoMatcher(40, 20, disparities=16, **CPU, **given).settings == matcher.settings


def test_an_option_without_effect_is_said(small: Pair) -> None:
    with pytest.warns(UserWarning, match="smoothness has no effect with method sgm"):
        gpu_stereo.match(*small, 16, smoothness="potts", **CPU)


def test_one_matcher_takes_every_kind_of_samples(small: Pair) -> None:
    matcher = gpu_stereo.StereoMatcher(160, 96, **CPU)
    for kind in ("uint8", "uint16", "uint8"):
        for samples in (1, 3):
            pair = [np.stack([image.astype(kind)] * samples, 2) for image in small]
            assert same(matcher.compute(*pair), gpu_stereo.match(*pair, **CPU))


def test_the_check_compares_every_stage(small: Pair) -> None:
    stages = gpu_stereo.check(*small, 16, **CPU)
    assert len(stages) >= 5
    assert all(stage.mismatches == 0 and stage.elements > 0 for stage in stages)
    with pytest.raises(gpu_stereo.InputError, match="which check compares with"):
        gpu_stereo.check(*small, 16, device="reference")


def test_every_device_gives_the_same_bits(small: Pair) -> None:
    expected = gpu_stereo.match(*small, 32, device="reference")
    devices: list[Any] = ["auto", "cpu"]
    for adapter in gpu_stereo.adapters():
        devices += [adapter.index, adapter.name]
    for device in devices:
        assert same(gpu_stereo.match(*small, 32, device=device), expected), device


