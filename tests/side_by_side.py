"""Runs all tests as `cargo test` does, but the test programs side by side instead of one after the other.

    python3 tests/side_by_side.py     # ./test does this when it is given no arguments

A driver compiles each kernel with one thread, and some tests wait for other processes, so one program at a time leaves
cores idle. As many programs run as there are cores; what a program prints is shown when it has ended. Each has
RUST_TEST_THREADS threads, by default as many as cores. Needs nothing but Python 3.8.
"""
import concurrent.futures
import json
import os
import re
import subprocess
import sys
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))

# Built at once, so that dependencies are built once, with the features of all; gpu-stereo-python is tested by python/test.
PACKAGES = ["gpu-stereo", "gpu-stereo-cli", "gpu-stereo-python", "gpu-stereo-viewer"]
SELECTED = [part for package in PACKAGES for part in ("-p", package)] + ["--features", "gpu-stereo/tracing"]

# Those that take longest begin first, so that no long one is left alone at the end.
LONGEST = ["library", "lib", "command", "viewer"]

RESULT = re.compile(r"^test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored", re.MULTILINE)


def built():
    """Builds all; of each test program its name, its command, and the folder of its package."""
    targets = ["--lib", "--bins", "--tests", "--examples"]
    build = ["cargo", "build", *SELECTED, *targets, "--locked", "--message-format", "json-render-diagnostics"]
    environment = {**os.environ, "PYO3_BUILD_EXTENSION_MODULE": "1"} # a module, which no library of Python is linked to
    process = subprocess.run(build, cwd=ROOT, stdout=subprocess.PIPE, text=True, env=environment)
    if process.returncode != 0:
        sys.exit(process.returncode)
    programs = {}
    for line in process.stdout.splitlines():
        message = json.loads(line)
        if message["reason"] == "compiler-artifact" and message["profile"]["test"] and message["executable"]:
            kind, name = message["target"]["kind"][0], message["target"]["name"]
            folder = os.path.dirname(message["manifest_path"])
            programs[name if kind in ("test", "example") else kind] = [message["executable"]], folder
    return programs


def main():
    start = time.monotonic()
    programs = built()
    if not programs:
        sys.exit("cargo named no test program")
    programs["doc"] = ["cargo", "test", "--locked", "--doc", *SELECTED], ROOT
    order = sorted(programs, key=lambda name: LONGEST.index(name) if name in LONGEST else len(LONGEST))
    print(f"built in {time.monotonic() - start:.0f} s; {len(order)} programs", flush=True)

    shown, running = threading.Lock(), set()
    cores = os.cpu_count() or 1
    environment = {"RUST_TEST_THREADS": str(cores), **os.environ}

    def run(name):
        began = time.monotonic()
        command, folder = programs[name]
        with shown:
            process = subprocess.Popen(
                command, cwd=folder, env={**environment, "CARGO_MANIFEST_DIR": folder}, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, text=True, errors="replace",
            )
            running.add(process)
        output, _ = process.communicate()
        with shown:
            running.discard(process)
            print(f"\n-- {name} ({time.monotonic() - began:.0f} s)\n{output.strip()}", flush=True)
        counts = [sum(int(found[i]) for found in RESULT.findall(output)) for i in range(3)]
        ran = bool(RESULT.search(output))
        return name, process.returncode == 0 and ran, counts

    with concurrent.futures.ThreadPoolExecutor(cores) as pool:
        tasks = [pool.submit(run, name) for name in order]
        try:
            results = [task.result() for task in tasks]
        except BaseException:
            for task in tasks:
                task.cancel()
            with shown:
                for process in running:
                    process.terminate()
            raise
    passed, failed, ignored = (sum(counts[i] for _, _, counts in results) for i in range(3))
    bad = [name for name, good, _ in results if not good]
    print(f"\n{passed} passed, {failed} failed, {ignored} skipped\nin {time.monotonic() - start:.0f} s", flush=True)
    if bad:
        sys.exit(f"failed: {', '.join(bad)}; alone: cargo test --lib, --bin gpu-stereo or --test NAME")


if __name__ == "__main__":
    main()
