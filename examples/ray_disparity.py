"""Disparities of a list of pairs on many machines, with Ray Data.

    pip install gpu-stereo "ray[data]"
    python examples/ray_disparity.py pairs.csv -o maps --disp 128
    python examples/ray_disparity.py pairs.csv -o maps --disp 128 --address auto --actors 1,64 --gpus 0.5

The list is that of `gpu-stereo batch`: `left,right,name` a line, paths relative to the list's folder. All machines must see the
images and the output folder at the same paths: a shared file system.

A pool of actors, each of which holds one matcher, takes blocks of pairs. Of each pair there is a map in the output folder,
`NAME.png`, 16 bits as KITTI's (256 a pixel, 0 invalid); with `--format parquet` the same PNG is a column instead. Of each block
there is a Parquet file in `OUT/rows`, with a row for each pair: what was computed, or the error that it failed with.

Run it again after whatever happened: pairs that have a row are not computed again (failed ones only with `--retry`). A file
appears under its name when it is complete, and a block that is computed twice, since an actor died, writes the same files again. A
pair whose actor died three times while it was computed counts as failed. docs/BATCH.md says when this is worth it.
"""

from __future__ import annotations

import argparse
import collections
import concurrent.futures
import csv
import hashlib
import json
import os
import pathlib
import struct
import sys
import tempfile
import time
import zlib
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import ray
import ray.data

import gpu_stereo

# So often may the process end while it computes one pair.
DEATHS = 3
COLUMNS = pa.schema(
    [
        ("name", pa.string()), ("left", pa.string()), ("right", pa.string()), ("error", pa.string()),
        ("width", pa.int32()), ("height", pa.int32()), ("valid", pa.float32()), ("ms", pa.float32()), ("device", pa.string()),
        ("png", pa.binary()),
    ]
)  # fmt: skip


class Refused(Exception):
    """A list or a folder that is not as it must be: one line."""


def read_list(path: pathlib.Path) -> list[dict[str, str]]:
    """The pairs of a CSV, with absolute paths and the names of their maps."""
    found: list[dict[str, str]] = []
    order = ["left", "right", "name"]
    folder = path.resolve().parent
    with open(path, newline="", encoding="utf-8") as file:
        for fields in csv.reader(line for line in file if line.strip() and not line.lstrip().startswith("#")):
            fields = [field.strip() for field in fields]
            if not found and {"left", "right"} <= set(fields):
                order = fields
                continue
            row = dict(zip(order, fields, strict=False))
            if not row.get("left") or not row.get("right"):
                raise Refused(f"{path}: {','.join(fields)!r} has no left and right image")
            name = row.get("name") or str(pathlib.PurePath(row["left"]).with_suffix(""))
            if pathlib.PurePath(name).is_absolute() or ".." in pathlib.PurePath(name).parts or name == "rows":
                raise Refused(f"{path}: the name {name!r} leads out of the output folder; give the pair another one")
            found.append({"name": name, "left": str(folder / row["left"]), "right": str(folder / row["right"])})
    names = [row["name"] for row in found]
    twice = next((name for name in names if names.count(name) > 1), None) if len(set(names)) < len(names) else None
    if twice is not None:
        raise Refused(f"{path}: two pairs have the name {twice!r}; give them others in a third column")
    return found


def write_whole(path: pathlib.Path, contents: bytes) -> None:
    """Writes a file that appears under its name when it is complete."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".begun-", delete=False) as file:
        try:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
            os.replace(file.name, path)
        except BaseException:
            os.unlink(file.name)
            raise


def png16(raw: np.ndarray) -> bytes:
    """A map as KITTI's PNG: 256 a pixel, 0 where there is no disparity."""
    valid = raw != -32768
    if (raw[valid] < 0).any() or (raw[valid] >= 4096).any():
        raise ValueError("a PNG holds disparities from 0 to 255.9 px; search a range within that")
    samples = np.where(valid, np.maximum(raw.astype(np.int32) * 16, 1), 0).astype(">u2")
    height, width = samples.shape
    lines = np.zeros((height, 1 + 2 * width), np.uint8)
    lines[:, 1:] = samples.view(np.uint8)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines.tobytes(), 3)) + chunk(b"IEND", b"")


class Disparities:
    """The actor: takes a block of pairs, writes their maps and the block's rows, and gives the names back."""

    def __init__(self, out: str, settings: dict[str, Any]) -> None:
        self.out = pathlib.Path(out)
        self.settings = settings
        self.matcher: gpu_stereo.StereoMatcher | None = None
        # Threads read the next pairs and write the maps before while this one is computed.
        self.files = concurrent.futures.ThreadPoolExecutor(3)

    def __call__(self, block: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        pairs = [{key: str(block[key][at]) for key in ("name", "left", "right")} for at in range(len(block["name"]))]
        reading: collections.deque[concurrent.futures.Future[Any]] = collections.deque()
        rows: list[dict[str, Any]] = []
        writing: collections.deque[concurrent.futures.Future[dict[str, Any]]] = collections.deque()
        for at, pair in enumerate(pairs):
            for ahead in pairs[at + len(reading) : at + 2]:
                reading.append(self.files.submit(gpu_stereo.read_pair, ahead["left"], ahead["right"]))
            writing.append(self.files.submit(self.finish, pair, self.computed(pair, reading.popleft())))
            if len(writing) > 2:
                rows.append(writing.popleft().result())
        rows += [row.result() for row in writing]
        # The same block has the same file, however often it is computed.
        key = hashlib.sha256("\n".join(pair["name"] for pair in pairs).encode()).hexdigest()[:32]
        buffer = pa.BufferOutputStream()
        pq.write_table(pa.Table.from_pylist(rows, COLUMNS), buffer, compression="none" if self.inline else "zstd")
        write_whole(self.out / "rows" / f"{key}.parquet", buffer.getvalue().to_pybytes())
        return {
            "name": np.array([row["name"] for row in rows], dtype=object),
            "failed": np.array([row["error"] is not None for row in rows]),
        }

    @property
    def inline(self) -> bool:
        return bool(self.settings["format"] == "parquet")

    def begun(self, pair: dict[str, str]) -> pathlib.Path:
        """Where it is noted that the pair has been begun: one line for each time, with the process."""
        return self.out / "begun" / hashlib.sha256(pair["name"].encode()).hexdigest()[:32]

    def computed(self, pair: dict[str, str], images: concurrent.futures.Future[Any]) -> dict[str, Any]:
        """The map of a pair and what is told of it, or why there is none."""
        note = self.begun(pair)
        note.parent.mkdir(parents=True, exist_ok=True)
        deaths = len(note.read_text(encoding="utf-8").splitlines()) if note.exists() else 0
        if deaths >= DEATHS:
            return {"error": f"the process ended {deaths} times while it computed this pair"}
        with open(note, "a", encoding="utf-8") as file:
            file.write(f"{os.getpid()}\n")
        try:
            left, right = images.result()
            started = time.perf_counter()
            height, width = left.shape[:2]
            if self.matcher is None or (self.matcher.width, self.matcher.height) != (width, height):
                self.matcher = gpu_stereo.StereoMatcher(
                    width, height, preset=self.settings["preset"], disparities=self.settings["disparities"],
                    device=self.settings["device"], **self.settings["options"],
                )  # fmt: skip
            raw = self.matcher.compute(left, right).raw
        except (gpu_stereo.Error, OSError, ValueError) as error:
            if isinstance(error, gpu_stereo.DeviceError):
                self.matcher = None
            return {"error": str(error)}
        ms = 1000 * (time.perf_counter() - started)
        return {"raw": raw, "width": width, "height": height, "ms": ms, "device": self.matcher.device}

    def finish(self, pair: dict[str, str], computed: dict[str, Any]) -> dict[str, Any]:
        """Writes the map of a pair. The result is its row."""
        row = {**pair, "error": None, **computed}
        raw = row.pop("raw", None)
        try:
            if raw is not None:
                row["valid"] = float((raw != -32768).mean())
                png = png16(raw)
                if self.inline:
                    row["png"] = png
                else:
                    write_whole(self.out / f"{pair['name']}.png", png)
        except (OSError, ValueError) as error:
            row["error"] = str(error)
        self.begun(pair).unlink(missing_ok=True)
        return row


def finished(out: pathlib.Path, retry: bool) -> set[str]:
    """The names of the pairs that have a row; with `retry` only of those that have a map."""
    names: set[str] = set()
    for path in (out / "rows").glob("*.parquet"):
        table = pq.read_table(path, columns=["name", "error"])
        names.update(row["name"] for row in table.to_pylist() if not retry or row["error"] is None)
    return names


def ensure_settings(out: pathlib.Path, settings: dict[str, Any]) -> None:
    """Notes with what settings the maps of the folder are made; a folder of others is refused."""
    path = out / "ray_disparity.json"
    made = json.dumps({**settings, "version": gpu_stereo.__version__}, indent=1, sort_keys=True)
    if not path.exists():
        write_whole(path, made.encode())
    elif path.read_text(encoding="utf-8") != made:
        raise Refused(f"the maps in {out} were made with other settings ({path}); take another folder")


def run(given: argparse.Namespace) -> tuple[int, int, int]:
    """Computes what is missing: how many pairs were there already, were computed, and failed."""
    out = pathlib.Path(given.out).resolve()
    settings = {
        "preset": given.preset, "disparities": given.disp, "device": given.device, "format": given.format,
        "options": dict(given.option),
    }  # fmt: skip
    pairs = read_list(pathlib.Path(given.pairs))
    ensure_settings(out, settings)
    done = finished(out, given.retry)
    missing = [pair for pair in pairs if pair["name"] not in done]
    if given.retry:
        for note in (out / "begun").glob("*"):
            note.unlink()
    if not missing:
        return len(pairs), 0, 0
    blocks = -(-len(missing) // given.block)
    data = ray.data.from_items(missing, override_num_blocks=blocks).map_batches(
        Disparities,
        fn_constructor_args=(str(out), settings),
        batch_size=None,  # a block as it is, so that it stays the same when it is computed again
        compute=ray.data.ActorPoolStrategy(min_size=given.actors[0], max_size=given.actors[1]),
        num_cpus=given.cpus,
        num_gpus=given.gpus,
    )
    failed = 0
    for batch in data.iter_batches(batch_size=1024):
        failed += int(batch["failed"].sum())
        for name in batch["name"][batch["failed"]]:
            print(f"ray_disparity.py: {name} failed", file=sys.stderr)
    return len(pairs) - len(missing), len(missing) - failed, failed


def option(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise argparse.ArgumentTypeError(f"{text!r} is not NAME=VALUE, such as uniqueness=10")
    return name.replace("-", "_"), value


def pool(text: str) -> tuple[int, int]:
    counts = [int(part) for part in text.split(",")]
    if not 1 <= len(counts) <= 2 or min(counts) < 1 or counts[-1] < counts[0]:
        raise argparse.ArgumentTypeError(f"{text!r} is not N or MIN,MAX, 1 or more")
    return counts[0], counts[-1]


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser(prog="ray_disparity.py", description="Disparities of a list of pairs, with Ray Data.")
    made.add_argument("pairs", help="a CSV, left,right,name a line")
    made.add_argument("-o", "--out", required=True, help="the output folder")
    made.add_argument("--disp", type=int, required=True, help="disparities to search, in pixels")
    made.add_argument("--preset", default="balanced")
    made.add_argument("--option", type=option, action="append", default=[], metavar="NAME=VALUE", help="any option of gpu-stereo")
    made.add_argument("--device", default="auto", help="auto, gpu, cpu, or an adapter's index or name")
    made.add_argument("--format", choices=["png", "parquet"], default="png")
    made.add_argument("--actors", type=pool, default=(1, 1), metavar="N|MIN,MAX", help="processes that compute, default 1")
    made.add_argument("--cpus", type=float, default=1, help="CPUs of an actor, default 1")
    made.add_argument("--gpus", type=float, default=0, help="GPUs of an actor, such as 0.5, default 0")
    made.add_argument("--block", type=int, default=64, help="pairs that are given to an actor at a time, default 64")
    made.add_argument("--retry", action="store_true", help="compute failed pairs again")
    made.add_argument("--address", help="of a Ray cluster; default: this machine alone")
    return made


def main() -> int:
    given = parser().parse_args()
    ray.init(address=given.address, log_to_driver=False)
    try:
        already, computed, failed = run(given)
    except Refused as refused:
        print(f"ray_disparity.py: {refused}", file=sys.stderr)
        return 2
    print(f"{computed} computed, {already} were there, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
