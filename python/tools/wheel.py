"""A wheel of the module's sources and of a library that Cargo has built, for tests: `maturin build` would compile it once more.

    python python/tools/wheel.py target/debug/lib_native.so FOLDER
"""

import base64
import hashlib
import pathlib
import sys
import sysconfig
import tomllib
import zipfile

HERE = pathlib.Path(__file__).resolve().parents[1]


def version() -> str:
    with open(HERE.parent / "Cargo.toml", "rb") as file:
        return str(tomllib.load(file)["workspace"]["package"]["version"])


def files(library: pathlib.Path, number: str, tag: str) -> dict[str, bytes]:
    with open(HERE / "pyproject.toml", "rb") as file:
        project = tomllib.load(file)["project"]
    needs = "".join(f"Requires-Dist: {need}\n" for need in project["dependencies"])
    about = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {number}\nRequires-Python: {project['requires-python']}\n{needs}"
    package = [path for path in sorted((HERE / "gpu_stereo").rglob("*")) if path.is_file() and "__pycache__" not in path.parts]
    inside = {path.relative_to(HERE).as_posix(): path.read_bytes() for path in package}
    inside["gpu_stereo/_native.abi3.so"] = library.read_bytes()
    information = f"gpu_stereo-{number}.dist-info"
    inside[f"{information}/METADATA"] = about.encode()
    inside[f"{information}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: tests\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    digests = {name: base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode() for name, data in inside.items()}
    record = [f"{name},sha256={digests[name]},{len(data)}\n" for name, data in inside.items()]
    inside[f"{information}/RECORD"] = "".join([*record, f"{information}/RECORD,,\n"]).encode()
    return inside


def main() -> None:
    library, folder = map(pathlib.Path, sys.argv[1:])
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    number, tag = version(), f"cp310-abi3-{platform}"
    folder.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(folder / f"gpu_stereo-{number}-{tag}.whl", "w") as wheel:
        for name, data in files(library, number, tag).items():
            wheel.writestr(name, data)


if __name__ == "__main__":
    main()
