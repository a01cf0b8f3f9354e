"""Dense stereo matching on any GPU, and on CPUs without a driver: the same bits everywhere.

>>> import gpu_stereo
>>> left, right = gpu_stereo.read_pair("data/motorcycle/left.png", "data/motorcycle/right.png")
>>> matched = gpu_stereo.match(left, right, disparities=64)
>>> matched.disparity.shape
(500, 741)
"""

from gpu_stereo._errors import DeviceError, Error, FileError, InputError, OutOfMemoryError
from gpu_stereo._native import (
    Adapter,
    Calibration,
    Camera,
    Matched,
    Option,
    Scores,
    StageCheck,
    StereoMatcher,
    Stream,
    __version__,
    adapters,
    check,
    evaluate,
    match,
    options,
    read_calibration,
    read_disparity,
    read_pair,
    rectify,
    stream,
)
from gpu_stereo._options import Options

__all__ = [
    "Adapter",
    "Calibration",
    "Camera",
    "DeviceError",
    "Error",
    "FileError",
    "InputError",
    "Matched",
    "Option",
    "Options",
    "OutOfMemoryError",
    "Scores",
    "StageCheck",
    "StereoMatcher",
    "Stream",
    "__version__",
    "adapters",
    "check",
    "evaluate",
    "match",
    "options",
    "read_calibration",
    "read_disparity",
    "read_pair",
    "rectify",
    "stream",
]
