"""What the parts of tests/portability/run share: the programs that cargo builds, and the rows of the table."""

import functools
import json
import os
import subprocess
import sys
from typing import NamedTuple

import fetch

sys.path.insert(0, str(fetch.ROOT / "tests"))
from side_by_side import SELECTED  # noqa: E402  (the features are those of ./test, so that nothing is built twice)

# Packages of npm: Dawn, and what leads Chromium.
NODE = ["webgpu@0.6.2", "playwright-core@1.65.1"]

PASSED, FAILED, NOT_TESTED = "passed", "FAILED", "NOT TESTED"


class Row(NamedTuple):
    """A line of the table."""

    name: str
    state: str
    what: str
    versions: str = ""


def tried(name, function, *given):
    """The row of a check, or why there is none."""
    try:
        return function(*given)
    except fetch.Missing as why:
        return Row(name, NOT_TESTED, str(why))


# How cargo is asked for the programs that are no test of their own.
KINDS = {"lib": ["--lib"], "compilers": ["--bench", "compilers"]}


@functools.lru_cache(maxsize=None)
def built(name):
    """The path of a program: the tests of the library inside (`lib`) and outside (`library`), benches/compilers.rs, or `translate`."""
    if name == "translate":
        command = ["cargo", "build", "--locked", "-p", "gpu-stereo-portability"]
    else:
        command = ["cargo", "test", "--locked", *SELECTED, "--no-run", *KINDS.get(name, ["--test", name])]
    command += ["--message-format", "json-render-diagnostics"]
    environment = {**os.environ, "PYO3_BUILD_EXTENSION_MODULE": "1"}  # as ./test builds the Python module
    done = subprocess.run(command, cwd=fetch.ROOT, stdout=subprocess.PIPE, text=True, env=environment)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)} failed")
    wanted = {"lib": "gpu_stereo", "translate": "gpu-stereo-portability"}.get(name, name)
    manifest = fetch.ROOT / ("tests/portability" if name == "translate" else "") / "Cargo.toml"
    messages = (json.loads(line) for line in done.stdout.splitlines() if line.startswith("{"))
    found = [
        message["executable"]
        for message in messages
        if message.get("executable") and message["target"]["name"] == wanted and message["manifest_path"] == str(manifest)
    ]
    if len(found) != 1:
        raise SystemExit(f"cargo built {len(found)} programs {wanted}, not one")
    return found[0]


def environment(**more):
    """This process's environment with other values; `None` takes a variable away."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("VK_", "WGPU_"))}
    kept.update({name: str(value) for name, value in more.items() if value is not None})
    return kept
