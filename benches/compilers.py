#!/usr/bin/env python3
"""What the compilers of real GPUs make of the kernels, without a GPU: registers, waves, spills, estimated times.

    benches/compilers.py make       # Mesa's drivers, and the shims that stand for cards, into target/compilers
    benches/compilers.py show       # compiles the kernels for all cards; the table on stdout
    benches/compilers.py compile    # every kernel of all presets compiles for all cards: 1 if one does not
    benches/compilers.py check      # the same, compared with benches/compilers.json: 1 if a figure is worse by over 10 %
    benches/compilers.py write      # the same, into benches/compilers.json and docs/COMPILERS.md
    benches/compilers.py show --cards navi21,dg2 --settings balanced --disparities 64 --kernels winner

The drivers RADV (AMD) and ANV (Intel) of Mesa compile as they would for the card that a shim in place of the kernel's driver
names; nothing is computed. Figures of compilers are estimates, not measurements.

Debian's packages are needed, and it says NOT TESTED where they cannot be had: the drivers come from the suite bookworm-backports,
the shims are built from Mesa's source of the suite trixie, which takes a minute or two on two cores. What that build needs is installed by
apt; meson and mako go into a virtual environment.
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests/portability"))
from fetch import Missing, apt, install, python, run, unpacked  # noqa: E402
from programs import built  # noqa: E402

WORK = ROOT / "target" / "compilers"
KEPT = ROOT / "benches" / "compilers.json"
PAGE = ROOT / "docs" / "COMPILERS.md"
MESA = "25.0.7"
DRIVERS = ("mesa-vulkan-drivers", "libdrm2", "libdrm-amdgpu1", "libdrm-intel1")
# What the shims are built with, beside Mesa's source and what PyPI has.
BUILD = ("gcc", "g++", "ninja-build", "pkg-config", "bison", "flex", "zlib1g-dev", "libdrm-dev", "libelf-dev", "libexpat1-dev")

# The cards, and the variables that name them to the shims.
AMD, INTEL = "amd", "intel"
CARDS = {"navi21": AMD, "navi31": AMD, "vega10": AMD, "tgl": INTEL, "dg2": INTEL}

# Figures that may not get worse, and whether more is worse.
WORSE = {"vgprs": 1, "waves": -1, "spills": 1, "scratch": 1, "time": 1, "simd": -1, "cycles": 1}
TOLERANCE = 0.10


def not_tested(why):
    print(f"NOT TESTED: {why}")
    sys.exit(0)


def make_drivers():
    unpacked("bookworm-backports", "drivers", DRIVERS, WORK / "drivers")
    # The loader takes the library of an absolute path.
    for card in ("radeon", "intel"):
        icd = next((WORK / "drivers/usr/share/vulkan/icd.d").glob(f"{card}_icd*.json"))
        told = json.loads(icd.read_text())
        told["ICD"]["library_path"] = str(library(f"libvulkan_{card}.so"))
        (WORK / f"{card}.json").write_text(json.dumps(told))


def library(name):
    return WORK / "drivers/usr/lib/x86_64-linux-gnu" / name


def make_shims():
    install(*BUILD)
    folder = apt("trixie", "deb-src", "update")
    apt("trixie", "deb-src", "source", "--download-only", "mesa")
    archive = folder / f"mesa_{MESA}.orig.tar.xz"
    if not archive.exists():
        raise Missing(f"Debian's suite trixie has no Mesa {MESA}")
    source, made = WORK / f"mesa-{MESA}", WORK / "build"
    if not source.exists():
        shutil.unpack_archive(archive, WORK)
    # The shims need no newer libdrm; the driver, which does, is not built.
    build = source / "meson.build"
    build.write_text(re.sub(r"_drm_amdgpu_ver = '[^']*'", "_drm_amdgpu_ver = '2.4.100'", build.read_text()))
    tools = python("meson", "meson", "mako", "pyyaml", "packaging").parent
    environment = {**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"}
    off = ("llvm", "glx", "egl", "gbm", "zstd")
    options = ["-Dtools=drm-shim,intel", "-Dvulkan-drivers=amd,intel_hasvk", "-Dgallium-drivers=", "-Dplatforms="]
    options += [f"-D{name}=disabled" for name in off] + ["-Dopengl=false"]
    if not (made / "build.ninja").exists():
        run(["meson", "setup", made, source, *options], env=environment)
    shims = [shim(AMD), shim(INTEL)]
    run(["ninja", "-C", made, *(path.relative_to(made) for path in shims)], env=environment)


def shim(vendor):
    return WORK / "build" / {
        AMD: "src/amd/drm-shim/libamdgpu_noop_drm_shim.so",
        INTEL: "src/intel/tools/libintel_noop_drm_shim.so",
    }[vendor]


def make(_):
    WORK.mkdir(parents=True, exist_ok=True)
    try:
        if not (WORK / "intel.json").exists():
            make_drivers()
        if not (shim(AMD).exists() and shim(INTEL).exists()):
            make_shims()
    except Missing as error:
        not_tested(f"Mesa's drivers or shims cannot be had: {error}")


def compiled(program, card, given):
    """What the driver prints while it compiles for a card."""
    vendor = CARDS[card]
    names = {AMD: "radeon", INTEL: "intel"}[vendor]
    variables = {
        AMD: {"AMDGPU_GPU_ID": card, "RADV_DEBUG": "shaderstats,nocache"},
        INTEL: {"INTEL_STUB_GPU_PLATFORM": card, "INTEL_DEBUG": "cs", "ANV_ENABLE_PIPELINE_CACHE": "false"},
    }[vendor]
    environment = {
        **os.environ,
        **variables,
        "LD_PRELOAD": str(shim(vendor)),
        "LD_LIBRARY_PATH": str(library("")),
        "VK_DRIVER_FILES": str(WORK / f"{names}.json"),
        "VK_ICD_FILENAMES": str(WORK / f"{names}.json"),
        "MESA_SHADER_CACHE_DISABLE": "true",
        "WGPU_BACKEND": "vulkan",
    }
    command = [program, "--settings", given.settings, "--disparities", given.disparities]
    done = subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    text = done.stderr.decode(errors="replace")
    if done.returncode != 0:
        told = [line for line in text.splitlines() if "panicked" in line or line.startswith(card)]
        sys.exit(f"{card}: {program} failed: " + " ".join(told or text.splitlines()[-3:]))
    return text


# Names of RADV's figures.
OF_AMD = {
    "VGPRs": "vgprs",
    "Spilled VGPRs": "spills",
    "Scratch size": "scratch",
    "Subgroups per SIMD": "waves",
    "Inverse Throughput": "time",
    "LDS size": "lds",
    "Code size": "code",
}
OF_INTEL = re.compile(
    r"SIMD(?P<simd>\d+) shader: (?P<instructions>\d+) inst\w*\. \d+ loops\. (?P<cycles>\d+) cycles\. "
    r"(?P<spills>\d+):(?P<fills>\d+) spills:fills"
)


def figures(vendor, text):
    """The figures of each kernel that was compiled, in order."""
    if vendor == AMD:
        parts = re.split(r"\*\*\* SHADER STATS \*\*\*", text)[1:]
        lines = [re.findall(r"^([A-Z][\w ]+): (\d+)", part, re.M) for part in parts]
        return [{OF_AMD[name]: int(value) for name, value in part if name in OF_AMD} for part in lines]
    return [{name: int(value) for name, value in found.groupdict().items()} for found in OF_INTEL.finditer(text)]


def measured(given):
    """`{card: {setting N: {kernel: figures}}}`, and what compiled."""
    program = built("compilers")
    found, drivers = {}, {}
    for card in given.cards.split(","):
        text = compiled(program, card, given)
        drivers[card] = re.search(r"^== adapter (.*)$", text, re.M).group(1)
        of_card = found.setdefault(card, {})
        for refused in re.findall(r"^== refused (.*)$", text, re.M):
            if given.what == "compile":
                sys.exit(f"{card} does not take {refused}")
            print(f"note: {card} does not take {refused}", file=sys.stderr)
        for case, body in re.findall(r"^== begin ([^\n]*)\n((?:(?!^== begin).)*?)^== end$", text, re.M | re.S):
            names = re.findall(r"^== kernel (\S+)$", body, re.M)
            rows = figures(CARDS[card], body)
            if len(rows) != len(names):
                sys.exit(f"{card}, {case}: {len(names)} kernels, but figures of {len(rows)}")
            of_card[case] = {name: row for name, row in zip(names, rows) if re.search(given.kernels, name)}
    return found, drivers


def table(found, case=None):
    """Markdown: a row a kernel and case, a column a card."""
    cards = list(found)
    lines = ["| kernel | settings | " + " | ".join(cards) + " |", "|---|---|" + "---|" * len(cards)]
    cases = [one for one in found[cards[0]] if case is None or one in case]
    for one in cases:
        for kernel in found[cards[0]][one]:
            cells = [words(found[card][one].get(kernel, {})) for card in cards]
            lines.append(f"| {kernel} | {one} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def words(row):
    if not row:
        return ""
    spills = f", spills {row['spills']}" if row.get("spills") else ""
    scratch = f", scratch {row['scratch']}" if row.get("scratch") else ""
    if "vgprs" in row:
        return f"{row['vgprs']} / {row.get('waves', 0)} / {row.get('time', 0) / 1000:.1f}k{spills}{scratch}"
    return f"SIMD{row['simd']} / {row['cycles'] / 1000:.1f}k{spills}"


def show(given):
    found, drivers = measured(given)
    print("\n".join(f"{card}: {driver}" for card, driver in drivers.items()))
    print("\nAMD: VGPRs / waves a SIMD / inverse throughput. Intel: width / cycles.\n")
    print(table(found))


def worse(before, now):
    """What is worse than it was, by more than the tolerance."""
    faults = []
    for card, cases in before.items():
        for case, kernels in cases.items():
            for kernel, row in kernels.items():
                other = now.get(card, {}).get(case, {}).get(kernel)
                for name, sign in WORSE.items() if other else ():
                    old, new = row.get(name, 0), other.get(name, 0)
                    if sign * (new - old) > TOLERANCE * old:
                        faults.append(f"{card}, {case}, {kernel}: {name} {old} -> {new}")
    return faults


def check(given):
    kept = json.loads(KEPT.read_text())
    found, drivers = measured(given)
    for card, driver in drivers.items():
        if kept["drivers"].get(card) != driver:
            print(f"note: {card} was compiled by {kept['drivers'].get(card)}, now by {driver}")
    faults = worse(kept["figures"], found)
    print("\n".join(faults) or "no figure is worse by over 10 %")
    sys.exit(1 if faults else 0)


def compile_all(given):
    """A line a card; ends with an error where a kernel has no figures."""
    found, drivers = measured(given)
    for card, cases in found.items():
        kernels = sum(len(rows) for rows in cases.values())
        if not kernels:
            sys.exit(f"{card}: no kernel was compiled")
        print(f"{card} | {kernels} kernels of {len(cases)} settings | {drivers[card].replace(' | ', ', ')}")


HEAD = """# What compilers make of the kernels

Estimates of Mesa's compilers for cards that nobody had at hand, not measurements: `benches/compilers.py write`, {date}, Mesa
{mesa}. The schedule is the one of GPUs, images of 741x500 in gray. `benches/compilers.py check` fails if a figure has become worse by over 10 %;
all figures, of more settings and disparities, are in benches/compilers.json.

AMD (RADV): vector registers / waves a SIMD can hold / inverse throughput of a wave in thousands of cycles, smaller is faster. Intel (ANV):
invocations that one instruction works on / cycles of a thread. What is spilled or needs scratch memory is said.

"""


def write(given):
    found, drivers = measured(given)
    date = datetime.date.today().isoformat()
    told = json.dumps({"date": date, "mesa": MESA, "drivers": drivers, "figures": found}, indent=1)
    # A line a kernel.
    KEPT.write_text(re.sub(r"\{[^{}]*\}", lambda row: " ".join(row.group().split()), told) + "\n")
    shown = [case for case in next(iter(found.values())) if case.split()[1] in ("64", "600")]
    PAGE.write_text(HEAD.format(date=date, mesa=MESA) + table(found, shown) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("make", "compile", "show", "check", "write"))
    parser.add_argument("--cards", default=",".join(CARDS), metavar="NAME,..")
    parser.add_argument("--settings", default="classic,balanced,dense,bm", metavar="NAME,..")
    parser.add_argument("--disparities", default="64,256,600", metavar="N,..")
    parser.add_argument("--kernels", default="", metavar="REGEX", help="only kernels whose name has this")
    given = parser.parse_args()
    if given.what == "compile":
        given.settings, given.disparities = "classic,fast,balanced,strict,dense,accurate,sgm8,bm,bp", "64"
    if given.what != "make" and not (shim(AMD).exists() and shim(INTEL).exists()):
        make(given)
    {"make": make, "compile": compile_all, "show": show, "check": check, "write": write}[given.what](given)


if __name__ == "__main__":
    main()
