"""The kernels' texts through the compilers of every backend: SPIR-V, GLSL, MSL, HLSL, and WGSL as browsers read it."""

import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess

import fetch
from programs import FAILED, NODE, PASSED, Row, built, tried

HERE = pathlib.Path(__file__).resolve().parent
FOLDER = fetch.WORK / "kernels"


def shown(faults, most=5):
    """The first of many faults, on one line each."""
    more = [f".. and {len(faults) - most} more"] if len(faults) > most else []
    return "\n    ".join(faults[:most] + more)


def verdict(name, faults, what, versions):
    if faults:
        return Row(name, FAILED, f"{len(faults)} refused\n    {shown(faults)}", versions)
    return Row(name, PASSED, what, versions)


def written(folder, share, seed):
    """Writes texts and their translations into a folder; how many there are of each kind, and naga's errors. Of `share` texts one is taken,
    and of each kernel at least one."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    environment = {**os.environ, "GPU_STEREO_TEXTS": str(folder)}
    command = [built("lib"), "--ignored", "--exact", "gpu::kernels::tests::portable::texts_are_written"]
    told = subprocess.run(command, env=environment, cwd=fetch.ROOT, capture_output=True, text=True)
    if "test result: ok. 1 passed" not in told.stdout:
        raise SystemExit(f"the texts were not written:\n{told.stdout}{told.stderr}")
    kernels = set()
    for nth, file in enumerate(sorted(folder.glob("*.wgsl"))):
        kernel = file.stem.split("-", 1)[1]
        if kernel in kernels and nth % share != seed % share:
            file.unlink()
        kernels.add(kernel)
    return *translated(folder), len(kernels)


def translated(folder):
    told = subprocess.run([built("translate"), folder], capture_output=True, text=True)
    counts = {kind: int(count) for count, kind in re.findall(r"^(\d+) (\S+)$", told.stdout, re.M)}
    faults = [line for line in told.stderr.splitlines() if line.strip()]
    if told.returncode not in (0, 1) or (told.returncode == 1 and not faults):
        raise SystemExit(f"the translation ended with {told.returncode}:\n{told.stderr}")
    return counts, faults


def side_by_side(work, items):
    """The results of `work` for all items, on all cores."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        return list(pool.map(work, items))


def spirv(name, folder):
    """spirv-val, as Vulkan demands it."""
    tools = fetch.unpacked(fetch.release(), "texts", ["spirv-tools", "glslang-tools"])
    program = tools / "usr/bin/spirv-val"

    def fault(file):
        target = "vulkan1.3" if file.name.endswith(".trusted.spv") else "vulkan1.1"
        told = subprocess.run([program, "--target-env", target, file], capture_output=True, text=True)
        first = (told.stdout + told.stderr).strip().splitlines()
        return f"{file.name}: {first[0] if first else 'refused'}" if told.returncode else None

    files = sorted(folder.glob("*.spv"))
    faults = [fault for fault in side_by_side(fault, files) if fault]
    version = fetch.run([program, "--version"]).split()[1]
    return verdict(name, faults, f"{len(files)} modules", f"SPIRV-Tools {version}")


def open_gl(name, folder):
    """glslangValidator, for OpenGL ES 3.1 and OpenGL 4.5."""
    tools = fetch.unpacked(fetch.release(), "texts", ["spirv-tools", "glslang-tools"])
    program = tools / "usr/bin/glslangValidator"

    def faults_of(files):
        told = subprocess.run([program, *files], capture_output=True, text=True)
        # The name of a file stands before its messages.
        parts = re.split(r"^(?=\S+\.(?:comp|vert|frag)$)", told.stdout, flags=re.M)
        wrong = [part.splitlines() for part in parts if "ERROR" in part]
        found = [f"{pathlib.Path(lines[0]).name}: {next(line for line in lines if 'ERROR' in line)}" for lines in wrong]
        return found or ([f"{files[0].name} or one of the next: refused"] if told.returncode else [])

    files = sorted(file for kind in ("comp", "vert", "frag") for file in folder.glob(f"*.{kind}"))
    batches = [files[i : i + 100] for i in range(0, len(files), 100)]
    faults = [fault for found in side_by_side(faults_of, batches) for fault in found]
    version = re.search(r"Glslang Version: (?:\d+:)?(\S+)", fetch.run([program, "--version"])).group(1)
    return verdict(name, faults, f"{len(files)} texts", f"glslang {version}")


def metal(name, folder):
    """libclang with the declarations of metal_stdlib that are used: errors of types, names and address spaces."""
    python = fetch.python("clang", "libclang==18.1.1")
    told = subprocess.run([python, HERE / "metal.py", folder], capture_output=True, text=True)
    found = re.search(r"^(\d+) texts, clang (.*)$", told.stdout, re.M)
    if not found or told.returncode not in (0, 1):
        raise SystemExit(f"metal.py ended with {told.returncode}:\n{told.stdout}{told.stderr}")
    faults = [line for line in told.stderr.splitlines() if line]
    return verdict(name, faults, f"{found[1]} texts", f"clang {found[2]}")


def direct_x(name, folder):
    """Written alone: there is no compiler of HLSL here that finds no false faults."""
    files = list(folder.glob("*.hlsl"))
    empty = [file.name for file in files if "[numthreads(" not in file.read_text() and "SV_Position" not in file.read_text()]
    return verdict(name, empty, f"{len(files)} texts", "")


def tint(name, folder):
    """Dawn's compiler, which Chromium has."""
    modules = fetch.npm("node", *NODE)
    told = subprocess.run(["node", HERE / "tint.mjs", modules, folder], capture_output=True, text=True, timeout=300)
    found = re.search(r"^(\d+) texts, (\d+) left out", told.stdout, re.M)
    if not found or told.returncode not in (0, 1):
        raise SystemExit(f"tint.mjs ended with {told.returncode}:\n{told.stdout}{told.stderr}")
    faults = [line for line in told.stderr.splitlines() if line]
    what = f"{found[1]} texts; {found[2]} need integers of 64 bits, which browsers have not"
    return verdict(name, faults, what, f"Dawn of npm {NODE[0].replace('@', ' ')}")


# Each compiler: its row, and what asks it.
COMPILERS = {
    "spirv": ("SPIR-V: spirv-val", spirv),
    "glsl": ("GLSL: glslangValidator", open_gl),
    "msl": ("MSL: clang, declarations of ours", metal),
    "hlsl": ("HLSL: written, compiled by none", direct_x),
    "tint": ("WGSL: Tint", tint),
}


def rows(given):
    counts, faults, kernels = written(FOLDER, given.share, given.seed)
    version = re.search(r'name = "naga"\nversion = "([^"]*)"', (fetch.ROOT / "Cargo.lock").read_text()).group(1)
    what = f"{counts['wgsl']} specialised texts of {kernels} kernels"
    if given.share > 1:
        what += f", one of {given.share}"
    yield verdict("WGSL: naga", faults, what, f"naga {version}")
    for name, compiler in COMPILERS.values():
        yield tried(name, compiler, name, FOLDER)
