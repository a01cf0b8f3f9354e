"""The test of the tests: what each check of tests/portability/run must find."""

import shutil

import browsers
import drivers
import fetch
import texts
from programs import FAILED, PASSED

FOLDER = fetch.WORK / "broken"

GOOD = """@group(0) @binding(0) var<storage, read_write> words: array<u32>;
@compute @workgroup_size(8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    words[id.x] = words[id.x] + 1u;
}
"""
# naga takes it; in a browser a barrier must not stand where some invocations of a workgroup may be missing.
LONELY = """@group(0) @binding(0) var<storage, read_write> words: array<u32>;
@compute @workgroup_size(8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if words[id.x] > 3u { return; }
    workgroupBarrier();
    words[id.x] = 1u;
}
"""


def texts_with(name, text):
    """A folder with one text and its translations; naga's errors."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    (FOLDER / f"{name}.wgsl").write_text(text)
    return texts.translated(FOLDER)[1]


def append(kind, what):
    for file in FOLDER.glob(f"*.{kind}"):
        file.write_text(file.read_text() + what)


def cut():
    """The last instruction of a SPIR-V module, the end of a function, is missing."""
    for file in FOLDER.glob("*.spv"):
        file.write_bytes(file.read_bytes()[:-4])


BROKEN = {
    "spirv": cut,
    "glsl": lambda: append("comp", "int broken() { return vec2(1.0); }\n"),
    "msl": lambda: append("metal", "metal::int4 broken(metal::uint4 a) { return a; }\n"),
    "hlsl": lambda: [file.write_text("") for file in FOLDER.glob("*.hlsl")],
    "tint": lambda: texts_with("lonely", LONELY),
}


def checks():
    """Each check, and whether it found what it must."""
    yield "naga takes the good text", not texts_with("good", GOOD)
    yield "naga refuses a broken one", bool(texts_with("broken", GOOD.replace("1u", "1.0")))
    for name, spoil in BROKEN.items():
        for state, change in ((PASSED, lambda: None), (FAILED, spoil)):
            texts_with("good", GOOD)
            change()
            try:
                yield f"{name}: {state} is told", texts.COMPILERS[name][1](name, FOLDER).state == state
            except fetch.Missing as why:
                yield f"{name}: NOT TESTED: {why}", True
    told = ["adapter llvmpipe (LLVM 15) | llvmpipe | Mesa 22.3.6 | Vulkan |", "9 of 9 settings are exact"]
    adapter = drivers.DRIVERS["lavapipe25"][2]
    yield "the row's own driver passes", drivers.judged("", told, None, "llvmpipe").state == PASSED
    yield "another driver than the row's is no pass", drivers.judged("", told, None, adapter).state == FAILED
    yield "a failed test is no pass", drivers.judged("", told, "stage winner differs", "llvmpipe").state == FAILED
    found = {"adapter": "none", "done": 20, "cases": 20, "stages": 200, "values": 1000, "faults": []}
    yield "a page without a fault passes", browsers.judged("", found, "").state == PASSED
    yield "a page with one fails", browsers.judged("", {**found, "faults": ["case 3: winner differs"]}, "").state == FAILED
    yield "a page that checked little fails", browsers.judged("", {**found, "done": 3}, "").state == FAILED
    try:
        yield "the validation layer objects to misuse", bool(drivers.misuse())
    except fetch.Missing as why:
        yield f"validation: NOT TESTED: {why}", True


def main():
    failed = 0
    for name, good in checks():
        failed += not good
        print(f"{'ok' if good else 'NOT FOUND'}: {name}", flush=True)
    return 1 if failed else 0
