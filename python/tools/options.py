"""Writes gpu_stereo/_options.py from the table of options of the installed package: python python/tools/options.py > python/gpu_stereo/_options.py"""

import gpu_stereo

HEAD = '''"""The keywords of a matcher, for type checkers. python/tools/options.py writes this file."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

if TYPE_CHECKING:
    from gpu_stereo._native import Calibration, Camera

__all__ = ["Options"]

# What is not installed, for instance torch, offers masks, too.
_Mask = Any


class Options(TypedDict, total=False):
    """The keywords of :class:`gpu_stereo.StereoMatcher`; None leaves the default."""

    channels: Literal["rgb", "bgr"]
    bits: Union[int, Literal["auto"]]
    confidence: bool
    right_map: bool
    timings: bool
    cameras: Union[Camera, Calibration, None]
    mask: Union[_Mask, tuple[_Mask, _Mask], None]
    weights: Union[str, PathLike[str], None]
'''


def type_of(option: gpu_stereo.Option) -> str:
    if option.values == ["on", "off"]:
        return 'Union[bool, Literal["on", "off"], None]'
    if option.values:
        words = [f'"{word}"' for word in option.values]
        numbers = [word for word in option.values if word.isdigit()]
        off = ["False"] if "off" in option.values else []
        return f"Literal[{', '.join(words + numbers + off)}, None]"
    if option.allowed.endswith("|off"):
        number = "float" if option.name.startswith("wls") else "int"
        return f'Union[{number}, Literal["off", False], None]'
    return "Union[int, None]"


def written() -> str:
    lines = [f"    # {option.help}\n    {option.name}: {type_of(option)}\n" for option in gpu_stereo.options()]
    return HEAD + "".join(lines)


if __name__ == "__main__":
    print(written(), end="")
