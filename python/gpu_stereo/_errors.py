"""The exceptions of this package. Their texts are those of the command ``gpu-stereo``."""

__all__ = ["DeviceError", "Error", "FileError", "InputError", "OutOfMemoryError"]


class Error(Exception):
    """The base of all exceptions of this package."""


class InputError(Error, ValueError):
    """An option, an image or a call is not as it must be."""


class FileError(Error, OSError):
    """A file cannot be read, or is not what it should be."""


class DeviceError(Error, RuntimeError):
    """No device is as was asked for, or a device failed."""


class OutOfMemoryError(Error, MemoryError):
    """A pair does not fit the memory that is left, or the device."""


for _name in __all__:
    globals()[_name].__module__ = "gpu_stereo"
