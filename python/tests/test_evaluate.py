"""Scores, beside those of the command and of a few lines of NumPy."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gpu_stereo

TRUTH = "data/motorcycle/disp_left.pfm"


def test_scores_are_the_command_s(
    motorcycle: tuple[np.ndarray, np.ndarray], command: Callable[..., Any], tmp_path: Path
) -> None:
    matched = gpu_stereo.match(*motorcycle, 64, device="cpu")
    np.save(tmp_path / "map.npy", matched.disparity)
    truth = gpu_stereo.read_disparity(TRUTH)
    scores = gpu_stereo.evaluate(matched, truth)
    told = command("eval", tmp_path / "map.npy", TRUTH)
    told = told.get("evaluation", told)
    for name, value in scores.as_dict().items():
        assert told[name] == pytest.approx(value, rel=1e-12), name
    assert scores.as_dict() == gpu_stereo.evaluate(matched.disparity, truth).as_dict()
    assert scores.as_dict() == gpu_stereo.evaluate(matched.disparity.astype("float64"), truth).as_dict()
    for name in ("pixels", "density", "bad_0_5", "bad_1", "bad_2", "bad_4", "average_error", "rms_error", "d1_est", "d1_all"):
        assert getattr(scores, name) == scores.as_dict()[name]


def test_scores_by_hand() -> None:
    truth = np.array([[10, 10, 10, np.nan, np.inf]], "float32")
    estimate = np.array([[10.25, 13, np.nan, 5, 5]], "float32")
    scores = gpu_stereo.evaluate(estimate, truth)
    assert (scores.pixels, scores.density) == (3, pytest.approx(2 / 3))
    assert (scores.bad_2, scores.bad_2_of_valid) == (pytest.approx(2 / 3), 0.5)
    assert scores.average_error == pytest.approx(3.25 / 2)
    masked = gpu_stereo.evaluate(estimate, truth, mask=np.array([[1, 0, 0, 1, 1]], "uint8"))
    assert (masked.pixels, masked.bad_2) == (1, 0)
    nothing = gpu_stereo.evaluate(np.full((1, 5), np.nan), truth)
    assert (nothing.density, nothing.average_error) == (0, None)
    # However it lies in memory.
    for layout in (np.asfortranarray, lambda a: np.repeat(a, 2, 1)[:, ::2], lambda a: a.astype(">f4")):
        assert gpu_stereo.evaluate(layout(estimate), layout(truth)).as_dict() == scores.as_dict()


@pytest.mark.parametrize(
    ("estimate", "truth", "mask", "text"),
    [
        (np.zeros((4, 5)), np.zeros((4, 6)), None, "5x4"),
        (np.zeros((4, 5), "int16"), np.zeros((4, 5)), None, "divide raw disparities by 16"),
        (np.zeros(5), np.zeros((4, 5)), None, r"\(5,\)"),
        (np.zeros((0, 5)), np.zeros((0, 5)), None, "5x0"),
        (np.zeros((4, 5)), np.zeros((4, 5)), np.zeros((4, 4), bool), "mask is 4x4"),
        (np.zeros((4, 5)), np.zeros((4, 5)), np.zeros((4, 5), bool), "no known pixel"),
        (np.zeros((4, 5)), np.full((4, 5), np.nan), None, "no known pixel"),
        (None, np.zeros((4, 5)), None, "NoneType"),
    ],
)
def test_what_is_wrong(estimate: Any, truth: Any, mask: Any, text: str) -> None:
    with pytest.raises(gpu_stereo.InputError, match=text):
        gpu_stereo.evaluate(estimate, truth, mask)
