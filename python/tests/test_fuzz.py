"""Arrays of every kind: an exception, or the map of the same numbers laid out plainly. Never a crash, never another map."""

import os
from typing import Any

import numpy as np
import pytest

import gpu_stereo

CASES = int(os.environ.get("GPU_STEREO_PYTHON_CASES", "150"))
DTYPES = ["u1", "<u2", ">u2", "u1", "<u2", "i1", "i2", "u4", "f4", "f8", "?", "O", "S3", "U2", "c8", "M8[s]", "V3", [("a", "u1"), ("b", "<u2")]]


def image(random: np.random.Generator) -> np.ndarray:
    """An array of any kind, often one that is taken."""
    dtype = np.dtype(DTYPES[random.integers(5) if random.random() < 0.8 else random.integers(len(DTYPES))])
    shape = [int(side) for side in random.integers(1, 24, 2)]
    if random.random() < 0.4:
        shape.append(int(random.choice([1, 3, 4, 3, 4, 2, 5])))
    if random.random() < 0.1:
        shape = [int(side) for side in random.integers(0, 4, random.integers(0, 5))]
    scale = int(random.integers(1, 4))
    room = [side * scale + int(random.integers(3)) for side in shape]
    values = random.integers(0, 256, [*room, dtype.itemsize or 1], dtype="u1")
    try:
        array = values.view(dtype)[..., 0] if dtype.itemsize else np.zeros(room, dtype)
    except (TypeError, ValueError):
        array = np.zeros(room, dtype)
    steps = tuple(slice(None, side * scale, scale) for side in shape)
    array = array[steps]
    for axis in range(array.ndim):
        if random.random() < 0.2:
            array = np.flip(array, axis)
    if random.random() < 0.3:
        array = np.asfortranarray(array)
    if random.random() < 0.1 and array.ndim >= 2:
        array = np.broadcast_to(array[:1], array.shape)
    if random.random() < 0.2:
        array = array.view()
        array.flags.writeable = False
    if random.random() < 0.2 and array.dtype.kind == "u":
        room_of_bytes = np.zeros(array.nbytes + 1, "u1")
        shifted = room_of_bytes[1:].view(array.dtype).reshape(array.shape)
        shifted[...] = array
        array = shifted
    return array


def plain(array: np.ndarray) -> np.ndarray:
    return np.array(array, array.dtype.newbyteorder("="), order="C")


def pair(seed: int) -> tuple[np.ndarray, np.ndarray, dict[str, Any], bool]:
    """Two images, keywords, and whether they are a pair."""
    random = np.random.default_rng(seed)
    left = image(random)
    if random.random() < 0.85:
        right = left[...] if random.random() < 0.5 else plain(left)
        right = np.flip(right, 0) if random.random() < 0.3 and right.ndim else right
    else:
        right = image(random)
    kinds = all(array.dtype.newbyteorder("=") in (np.dtype("u1"), np.dtype("u2")) for array in (left, right))
    shapes = all(array.ndim == 2 or (array.ndim == 3 and array.shape[2] in (1, 3, 4)) for array in (left, right))
    good = kinds and shapes and left.shape[:2] == right.shape[:2] and min(*left.shape, *right.shape) > 0
    return left, right, {"channels": ["rgb", "bgr"][random.integers(2)], "device": "cpu"}, good


@pytest.mark.parametrize("seed", range(CASES))
def test_any_pair(seed: int) -> None:
    left, right, options, good = pair(seed)
    before = plain(left).tobytes()
    try:
        matched = gpu_stereo.match(left, right, 8, **options)
    except gpu_stereo.InputError as error:
        assert not good, f"{left.dtype} {left.shape} {left.strides} was refused: {error}"
        assert str(error)
        return
    assert good, f"{left.dtype} {left.shape} and {right.dtype} {right.shape} were taken"
    assert plain(left).tobytes() == before
    assert matched.shape == left.shape[:2]
    np.testing.assert_array_equal(matched.raw, gpu_stereo.match(plain(left), plain(right), 8, **options).raw)


def test_many_pairs_are_taken_and_many_refused() -> None:
    taken = sum(pair(seed)[3] for seed in range(CASES))
    assert CASES / 4 < taken < CASES * 3 / 4


VALUES = [
    None, True, False, 0, -1, 3, 64, 2**31, 2**63, -(2**70), 0.5, 8.0, float("nan"), float("inf"), "", "on", "off", "auto", "\0", "ü",
    "x" * 5000, b"on", [], {}, (), object(), np.float32(3), np.int8(-3), np.uint64(2**63), np.bool_(True), np.array(5), 1j,
]  # fmt: skip


@pytest.mark.filterwarnings("ignore:.*no effect:UserWarning")
@pytest.mark.parametrize("name", [*(option.name for option in gpu_stereo.options()), "disparities", "preset", "device", "channels", "bits",
    "confidence", "right_map", "timings", "cameras", "mask", "weights"])  # fmt: skip
def test_any_value_of_any_keyword(name: str) -> None:
    gray = np.zeros((6, 24), "uint8")
    for value in VALUES:
        keywords: dict[str, Any] = {"disparities": 8, "device": "cpu", name: value}
        if name in ("schedule", "bp_levels", "bp_iterations") and value == 2**31:
            continue
        try:
            gpu_stereo.match(gray, gray, **keywords)
        except (gpu_stereo.Error, TypeError, ValueError) as error:
            assert str(error), (name, value)
