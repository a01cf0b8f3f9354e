"""What is accepted as an image, a map or a number, and how it is refused."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, SupportsIndex, cast

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    _Base = Exception
else:
    try:
        from cv2 import error as _Base
    except ImportError:
        _Base = Exception

Map = npt.NDArray[np.int16]
Image = npt.NDArray[np.uint8]
Rect = tuple[int, int, int, int]

_C_INT = range(-(2**31), 2**31)


class error(_Base):  # noqa: N801 - OpenCV's name
    """What is raised where OpenCV raises ``cv2.error``; where OpenCV is installed, it is one."""


def integer(name: str, value: object) -> int:
    """The number as OpenCV takes it: an integer that fits 32 bits; no float and no bool."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"Argument '{name}' must be integer, not bool")
    if not isinstance(value, SupportsIndex):
        raise TypeError(f"Argument '{name}' is required to be an integer, but is a {_kind(value)}")
    number = operator.index(value)
    if number not in _C_INT:
        raise ValueError(f"Argument '{name}' is {number}, which doesn't fit into 32 bits")
    return number


def number(name: str, value: object) -> float:
    """A real number."""
    if not isinstance(value, bool) and isinstance(value, (int, float, np.integer, np.floating)):
        return float(cast(float, value))
    raise TypeError(f"Argument '{name}' is required to be a number, but is a {_kind(value)}")


def rectangle(name: str, value: object) -> Rect:
    """x, y, width and height."""
    items: list[object] = list(cast(Iterable[object], value)) if isinstance(value, (tuple, list, np.ndarray)) else []
    if len(items) != 4:
        raise TypeError(f"Argument '{name}' is required to be (x, y, width, height), but is {value!r}")
    x, y, width, height = (integer(name, item) for item in items)
    return x, y, width, height


def _kind(value: object) -> str:
    return type(value).__name__


def _flat(name: str, value: object) -> npt.NDArray[Any]:
    """The array, without a third dimension of one channel."""
    if not isinstance(value, np.ndarray):
        raise error(f"{name} is required to be a NumPy array, but is a {_kind(value)}")
    given = cast("npt.NDArray[Any]", value)
    return given[:, :, 0] if given.ndim == 3 and given.shape[2] == 1 else given


def array(name: str, value: object, dtypes: Sequence[str]) -> npt.NDArray[Any]:
    """An array of two dimensions of one of the types; a third dimension of one channel is dropped."""
    given = _flat(name, value)
    if given.ndim != 2 or given.dtype.name not in dtypes or given.size == 0:
        raise error(
            f"{name} is required to be an array of height x width, not empty, of {' or '.join(dtypes)}, "
            f"but is {given.dtype} of the shape {given.shape}"
        )
    native: npt.NDArray[Any] = given.astype(given.dtype.newbyteorder("="), copy=False)
    return native


def map16(name: str, value: object) -> Map:
    """A map of disparities in 1/16 px."""
    return array(name, value, ["int16"])


def image(name: str, value: object, channels: Sequence[int]) -> Image:
    """An image of 8 bits with one of the numbers of channels; an image of one channel has two dimensions."""
    given = _flat(name, value)
    count = {2: 1, 3: given.shape[-1]}.get(given.ndim, 0) if given.ndim else 0
    if given.dtype != np.uint8 or count not in channels or given.size == 0:
        shapes = " or ".join("height x width" if count == 1 else f"height x width x {count}" for count in channels)
        raise error(
            f"{name} is required to be uint8, {shapes}, not empty, but is {given.dtype} of the shape {given.shape}"
        )
    return given


def into(given: npt.NDArray[Any] | None, computed: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The result in the caller's array, if that fits; else as it is, as OpenCV does it."""
    if given is None or given.dtype != computed.dtype or given.shape != computed.shape or not given.flags.writeable:
        return computed
    given[...] = computed
    return given
