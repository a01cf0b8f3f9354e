"""The npm package where browsers' own implementation of WebGPU runs it: Dawn in Node, and a page of headless Chromium."""

import functools
import json
import os
import pathlib
import shutil
import subprocess

import drivers
import fetch
from programs import FAILED, NODE, PASSED, Row

HERE = pathlib.Path(__file__).resolve().parent
DAWN, CHROMIUM = "Exact on Dawn in Node, Vulkan", "Exact in headless Chromium"


@functools.lru_cache(maxsize=None)
def package():
    """The folder of the npm package, which web/build makes."""
    done = subprocess.run([fetch.ROOT / "web/build"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    folder = fetch.ROOT / "web/dist/npm"
    if done.returncode != 0 or not (folder / "index.js").exists():
        raise fetch.Missing(f"web/build failed: {' '.join(done.stdout.strip().splitlines()[-3:])}")
    return folder


@functools.lru_cache(maxsize=None)
def cases(seed):
    """The folder with the cases."""
    folder = fetch.WORK / "cases"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    given = type("Given", (), {"seconds": 0, "seed": seed})
    _, why = drivers.tested(["cases_are_written"], {**os.environ, "GPU_STEREO_CASES": str(folder)}, given)
    if why:
        raise SystemExit(f"the cases were not written: {why}")
    return folder


def checked(name, script, variables, given, versions):
    modules = fetch.npm("node", *NODE)
    command = ["node", HERE / script, modules, package(), cases(given.seed), str(given.seconds)]
    try:
        done = subprocess.run(command, env=variables, capture_output=True, text=True, timeout=given.seconds + 600)
    except subprocess.TimeoutExpired as error:
        return Row(name, FAILED, f"no end within {error.timeout:.0f} s", versions)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode != 0 or not lines:
        return Row(name, FAILED, f"ended with {done.returncode}: {' '.join((done.stdout + done.stderr).split())[:600]}", versions)
    return judged(name, json.loads(lines[-1]), versions)


def judged(name, found, versions):
    """The row of what check.mjs found."""
    versions = f"{versions}{found['adapter']}"
    if found["faults"]:
        return Row(name, FAILED, f"{len(found['faults'])} of {found['done']}: {found['faults'][0]}", versions)
    # The presets on both schedules, and some more.
    if found["done"] < 12 or not found["values"]:
        return Row(name, FAILED, f"only {found['done']} settings were checked in the time", versions)
    what = f"{found['done']} of {found['cases']} settings are exact: {found['values']} values of {found['stages']} stages"
    return Row(name, PASSED, what, versions)


def dawn(given):
    variables = drivers.lavapipe25()  # Dawn takes no older one
    return checked(DAWN, "dawn.mjs", variables, given, f"npm webgpu {NODE[0].split('@')[1]}, lavapipe 25: ")


def chromium(given):
    fetch.install("chromium")
    return checked(CHROMIUM, "chromium.mjs", dict(os.environ), given, "")
