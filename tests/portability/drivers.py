"""The kernels on drivers for CPUs, beside the reference; under the validation layer; and through compilers for GPUs."""

import json
import os
import pathlib
import re
import subprocess
import sys

import fetch
from programs import FAILED, PASSED, Row, built, environment

LIBRARIES = "usr/lib/x86_64-linux-gnu"
# A driver that hangs ends here, in seconds.
PATIENCE = 900


def manifest(library, name):
    """The file that leads Vulkan's loader to a driver."""
    if not library.exists():
        raise fetch.Missing(f"{library} is not there")
    file = fetch.WORK / f"{name}.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    told = {"file_format_version": "1.0.0", "ICD": {"library_path": str(library), "api_version": "1.1.0"}}
    file.write_text(json.dumps(told))
    return file


def only(file):
    """The variables with which Vulkan's loader takes one driver."""
    return {"VK_DRIVER_FILES": file, "VK_ICD_FILENAMES": file, "WGPU_BACKEND": "vulkan"}


def lavapipe():
    fetch.install("mesa-vulkan-drivers", "libvulkan1")
    found = sorted(pathlib.Path("/usr/share/vulkan/icd.d").glob("lvp_icd*.json"))
    if not found:
        raise fetch.Missing("mesa-vulkan-drivers has no lavapipe here")
    return environment(**only(found[0]))


def lavapipe25():
    fetch.install("mesa-vulkan-drivers", "libvulkan1")  # for the libraries that both versions need
    folder = fetch.unpacked("bookworm-backports", "lavapipe25", ["mesa-vulkan-drivers", "libdrm2", "libdrm-amdgpu1"])
    libraries = folder / LIBRARIES
    return environment(**only(manifest(libraries / "libvulkan_lvp.so", "lavapipe25")), LD_LIBRARY_PATH=libraries)


def swiftshader():
    fetch.install("chromium", "libvulkan1")
    return environment(**only(manifest(pathlib.Path("/usr/lib/chromium/libvk_swiftshader.so"), "swiftshader")))


def open_gl():
    fetch.install("libegl1", "libgl1-mesa-dri")
    return environment(WGPU_BACKEND="gl", EGL_PLATFORM="surfaceless", LIBGL_ALWAYS_SOFTWARE="1")


VALIDATION, CARDS = "Vulkan validation layer", "RADV and ANV, no card"

# Each driver: its row, what makes its environment, and what its adapter must say, so that no row speaks of another driver.
DRIVERS = {
    "lavapipe": ("lavapipe of the system, Vulkan", lavapipe, r"^llvmpipe .*\| Vulkan"),
    "lavapipe25": ("lavapipe 25, Vulkan", lavapipe25, r"^llvmpipe .*\| Mesa 25\..*\| Vulkan"),
    "swiftshader": ("SwiftShader, Vulkan", swiftshader, r"^SwiftShader .*\| Vulkan"),
    "gl": ("llvmpipe, wgpu's backend for OpenGL", open_gl, r"^llvmpipe .*\| Gl\b"),
}


def tested(names, variables, given):
    """Runs ignored tests of tests/library/portability.rs; what they told, in lines, and why they failed."""
    command = [built("library"), "--ignored", "--nocapture", "--test-threads", "1", "--exact"]
    command += [f"portability::{name}" for name in names]
    variables = {**variables, "GPU_STEREO_SECONDS": str(given.seconds), "GPU_STEREO_SEED": str(given.seed)}
    variables["CARGO_MANIFEST_DIR"] = str(fetch.ROOT)
    try:
        done = subprocess.run(
            command, env=variables, cwd=fetch.ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            errors="replace", timeout=PATIENCE,
        )
    except subprocess.TimeoutExpired:
        return [], f"no end within {PATIENCE} s"
    told = re.findall(r"^== (.*)$", done.stdout, re.M)
    if done.returncode == 0 and f"test result: ok. {len(names)} passed" in done.stdout:
        return told, None
    panics = re.findall(r"^thread .* panicked at .*:\n(.*)$", done.stdout, re.M)
    return told, " / ".join(panics[:2]) or f"ended with {done.returncode}: {done.stdout.strip()[-300:]}"


def adapter_of(told):
    return next((line[len("adapter ") :] for line in told if line.startswith("adapter ")), "no adapter")


def worded(adapter):
    """Its parts that say something."""
    return ", ".join(part.strip() for part in adapter.split("|") if part.strip())


def settings_of(told):
    """How many settings were compared: of the presets, and of the covering set, whose line has the seed."""
    lines = [line.replace("settings are exact", "settings") for line in told if " settings " in line]
    return "; ".join(f"covering set: {line}" if "seed" in line else f"presets: {line}" for line in lines)


def judged(name, told, why, adapter):
    """The row of a driver."""
    found = adapter_of(told)
    if why:
        return Row(name, FAILED, why, worded(found))
    if not re.search(adapter, found):
        return Row(name, FAILED, f"another adapter answered: {found}", worded(found))
    return Row(name, PASSED, settings_of(told), worded(found))


def title(driver):
    return f"Exact on {DRIVERS[driver][0]}"


def exact(given, driver):
    _, variables, adapter = DRIVERS[driver]
    told, why = tested(["presets_are_exact", "covering_settings_are_exact"], variables(), given)
    return judged(title(driver), told, why, adapter)


class Layer:
    """The Vulkan validation layer, which writes its messages into a file."""

    def __init__(self):
        self.folder = fetch.unpacked(fetch.release(), "layers", ["vulkan-validationlayers"])
        self.log = fetch.WORK / "validation.log"
        settings = fetch.WORK / "vk_layer_settings.txt"
        wanted = {
            "debug_action": "VK_DBG_LAYER_ACTION_LOG_MSG",
            "report_flags": "error,warn,perf,info",
            "log_filename": self.log,
            "enables": "VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT",
        }
        settings.write_text("".join(f"khronos_validation.{name} = {value}\n" for name, value in wanted.items()))
        self.variables = {
            "VK_LAYER_PATH": self.folder / "usr/share/vulkan/explicit_layer.d",
            "VK_LAYER_SETTINGS_PATH": settings,
            "VK_INSTANCE_LAYERS": "VK_LAYER_KHRONOS_validation",
            "LD_LIBRARY_PATH": self.folder / LIBRARIES,
        }
        self.log.unlink(missing_ok=True)

    def messages(self):
        """Errors and warnings, also of performance; `None` without the layer's word that it is there."""
        text = self.log.read_text(errors="replace") if self.log.exists() else ""
        blocks = re.split(r"^(?=\S.*\((?:ERROR|WARN|PERF|INFO))", text, flags=re.M)
        blocks = [" ".join(block.split()) for block in blocks if block.strip()]
        status = [block for block in blocks if "Khronos Validation Layer Active" in block]
        return [block for block in blocks if not re.match(r"\S*\(INFO", block)] if status else None


def validation(given):
    layer = Layer()
    variables = {**lavapipe(), **{name: str(value) for name, value in layer.variables.items()}}
    variables["WGPU_DEBUG"] = "0"  # as embedders build it: this layer does not know the WGSL that debug information names as the source
    told, why = tested(["presets_are_exact"], variables, given)
    name = VALIDATION
    described = layer.variables["VK_LAYER_PATH"] / "VkLayer_khronos_validation.json"
    version = json.loads(described.read_text())["layer"]["api_version"]
    versions = f"layer {version} on {worded(adapter_of(told))}"
    messages = layer.messages()
    if why:
        return Row(name, FAILED, why, versions)
    if messages is None:
        return Row(name, FAILED, "the layer was not loaded", versions)
    if messages:
        return Row(name, FAILED, f"{len(messages)} messages, the first: {messages[0][:600]}", versions)
    return Row(name, PASSED, f"0 messages; {settings_of(told)}", versions)


def misuse():
    """An instance whose description is of another kind: the layer must object. Runs in a process of its own."""
    program = """
import ctypes
vulkan = ctypes.CDLL("libvulkan.so.1")
class Create(ctypes.Structure):
    _fields_ = [("kind", ctypes.c_int), ("next", ctypes.c_void_p), ("flags", ctypes.c_uint), ("application", ctypes.c_void_p),
                ("layers", ctypes.c_uint), ("names", ctypes.c_void_p), ("extensions", ctypes.c_uint), ("more", ctypes.c_void_p)]
instance = ctypes.c_void_p()
vulkan.vkCreateInstance(ctypes.byref(Create(kind=1, flags=64)), None, ctypes.byref(instance))
"""
    layer = Layer()
    variables = {**lavapipe(), **{name: str(value) for name, value in layer.variables.items()}}
    subprocess.run([sys.executable, "-c", program], env=variables, timeout=60)
    return layer.messages()


def cards(_):
    """RADV and ANV, which compile for cards that are not there."""
    command = [sys.executable, fetch.ROOT / "benches/compilers.py", "compile"]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if "NOT TESTED: " in done.stdout:
        raise fetch.Missing(done.stdout.split("NOT TESTED: ", 1)[1].strip())
    name = CARDS
    if done.returncode != 0:
        last = (done.stdout + done.stderr).strip().splitlines()[-3:]
        return Row(name, FAILED, " ".join(last), "")
    lines = [line.split(" | ") for line in done.stdout.splitlines() if line.count(" | ") == 2]
    if not lines:
        return Row(name, FAILED, f"no card was told: {done.stdout}", "")
    versions = sorted({driver.split(", ")[-1] for _, _, driver in lines})
    counts = sorted({what for _, what, _ in lines})
    cards = [f"{what} on {', '.join(card for card, other, _ in lines if other == what)}" for what in counts]
    return Row(name, PASSED, "; ".join(cards), f"RADV and ANV of {', '.join(versions)}")
