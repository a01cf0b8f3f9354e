"""Every .metal of a folder through clang, with the declarations of tests/portability/metal for Metal's library.

    python metal.py FOLDER      # in a virtual environment with libclang

Clang reads a text as C++17: it finds wrong types, names and calls; address spaces and Metal's attributes it does not know. Errors are on
stderr, a line a text, and the exit code is 1.
"""

import concurrent.futures
import importlib.metadata
import os
import pathlib
import re
import sys

import clang.cindex

HEADERS = pathlib.Path(__file__).resolve().parent / "metal"
OPTIONS = ["-x", "c++", "-std=c++17", "-nostdinc", "-nostdinc++", "-isystem", str(HEADERS), "-Wno-everything"]


def swizzle(found):
    """`.xy` of a vector, as C++ can have it."""
    return f".swizzle<{', '.join(str('xyzw'.index(axis)) for axis in found[1])}>()"


def fault(file):
    """The first error of a text."""
    text = re.sub(r"\.([xyzw]{2,4})\b", swizzle, file.read_text())
    parsed = clang.cindex.Index.create().parse(str(file), args=OPTIONS, unsaved_files=[(str(file), text)])
    errors = [one for one in parsed.diagnostics if one.severity >= clang.cindex.Diagnostic.Error]
    if not errors:
        return None
    place = errors[0].location
    return f"{file.name}: {pathlib.Path(place.file.name).name}:{place.line}: {errors[0].spelling}"


def main():
    files = sorted(pathlib.Path(sys.argv[1]).glob("*.metal"))
    if not files:
        sys.exit(f"{sys.argv[1]} has no .metal")
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        faults = [fault for fault in pool.map(fault, files) if fault]
    print(f"{len(files)} texts, clang {importlib.metadata.version('libclang')}")
    print("\n".join(faults), file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
