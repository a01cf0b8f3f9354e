"""The examples of every docstring run, and every name has one."""

import doctest
import inspect
import re

import pytest

import gpu_stereo

NAMES = [name for name in gpu_stereo.__all__ if not name.startswith("__")]
FUNCTIONS = [name for name in NAMES if inspect.isroutine(getattr(gpu_stereo, name))]


@pytest.mark.parametrize("name", ["gpu_stereo", *NAMES])
def test_examples(name: str) -> None:
    thing = gpu_stereo if name == "gpu_stereo" else getattr(gpu_stereo, name)
    text = inspect.getdoc(thing) or ""
    assert text, f"{name} has no docstring"
    test = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    if name in FUNCTIONS or name in ("StereoMatcher", "Camera"):
        assert test.examples, f"{name} has no example"
    failed = doctest.DocTestRunner().run(test).failed
    assert failed == 0


@pytest.mark.parametrize("name", NAMES)
def test_attributes_have_docstrings(name: str) -> None:
    thing = getattr(gpu_stereo, name)
    if inspect.isclass(thing) and thing.__module__ == "gpu_stereo" and not issubclass(thing, Exception | dict):
        for attribute, value in vars(thing).items():
            assert attribute.startswith("__") or inspect.getdoc(value), f"{name}.{attribute}"


def test_the_version_is_the_crate_s() -> None:
    assert re.fullmatch(r"\d+\.\d+\.\d+", gpu_stereo.__version__)
