"""Programs and libraries from Debian's, PyPI's and npm's packages, for tests/portability/run and benches/compilers.py.

What can be unpacked goes into a folder of the caller; `install` alone changes the system, as ./test does. What cannot be had is
`Missing`, with the reason.
"""

import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
WORK = ROOT / "target" / "portability"
KEYRING = "/usr/share/keyrings/debian-archive-keyring.gpg"


class Missing(Exception):
    """Something that a part needs cannot be had here."""


def run(command, **more):
    """Runs a command; its last words are the reason if it fails."""
    command = [str(part) for part in command]
    try:
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more).stdout
    except OSError as error:
        raise Missing(f"{command[0]}: {error.strerror}") from error
    except subprocess.CalledProcessError as error:
        last = " ".join((error.stdout or "").strip().splitlines()[-3:])
        raise Missing(f"{' '.join(command[:4])} failed: {last}") from error


def mirror():
    """The Debian mirror that the system uses."""
    told = run(["apt-get", "indextargets", "--format", "$(ORIGIN) $(LABEL) $(REPO_URI)"])
    found = sorted({line.split()[2] for line in told.splitlines() if line.startswith("Debian Debian ")})
    if not found:
        raise Missing("apt has no Debian mirror")
    return found[0]


def release():
    """The name of the system's Debian release."""
    lines = pathlib.Path("/etc/os-release").read_text().splitlines()
    names = [line.split("=", 1)[1] for line in lines if line.startswith("VERSION_CODENAME=")]
    if not names:
        raise Missing("the system is no Debian release")
    return names[0]


def apt(suite, kind, *command):
    """apt-get with lists of its own, of one suite; the folder that it works in."""
    folder = WORK / "apt" / f"{suite}-{kind}"
    for made in ("lists/partial", "cache/archives/partial"):
        (folder / made).mkdir(parents=True, exist_ok=True)
    source = folder / "sources.list"
    source.write_text(f"{kind} [signed-by={KEYRING}] {mirror()} {suite} main\n")
    options = {
        "Dir::Etc::sourcelist": source,
        "Dir::Etc::sourceparts": "/dev/null",
        "Dir::State::lists": folder / "lists",
        "Dir::Cache": folder / "cache",
        "APT::Sandbox::User": "root",
    }
    given = [part for name, value in options.items() for part in ("-o", f"{name}={value}")]
    run(["apt-get", "-qq", *given, *command], cwd=folder)
    return folder


def unpacked(suite, name, packages, into=None):
    """The folder with the files of Debian's packages, fetched once."""
    into = into or WORK / name
    done = into / ".done"
    if not done.exists() or done.read_text() != " ".join(packages):
        shutil.rmtree(into, ignore_errors=True)
        folder = apt(suite, "deb", "update")
        apt(suite, "deb", "download", *(f"{package}/{suite}" for package in packages))
        for package in packages:
            for file in folder.glob(f"{package}_*.deb"):
                run(["dpkg", "-x", file, into])
                file.unlink()
        done.write_text(" ".join(packages))
    return into


def install(*packages):
    """Installs what is missing of Debian's packages."""
    def absent(package):
        told = subprocess.run(["dpkg-query", "-W", "-f", "${Status}", package], capture_output=True, text=True)
        return not told.stdout.endswith(" installed")

    missing = [package for package in packages if absent(package)]
    if missing:
        sudo = [] if os.getuid() == 0 else ["sudo", "-n"]
        print(f"note: apt-get install {' '.join(missing)}", file=sys.stderr)
        run([*sudo, "apt-get", "-qq", "update"])
        wait = ["-o", "DPkg::Lock::Timeout=300"]
        run([*sudo, "env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "install", "-y", "-qq", *wait,
             "--no-install-recommends", *missing])


def python(name, *packages):
    """The Python of a virtual environment with packages of PyPI, made once."""
    folder = WORK / name
    done = folder / ".done"
    if not done.exists() or done.read_text() != " ".join(packages):
        run([sys.executable, "-m", "venv", folder])
        run([folder / "bin/python", "-m", "pip", "install", "--quiet", *packages])
        done.write_text(" ".join(packages))
    return folder / "bin/python"


def npm(name, *packages):
    """The folder with `node_modules` of npm's packages, made once."""
    folder = WORK / name
    done = folder / ".done"
    if not done.exists() or done.read_text() != " ".join(packages):
        folder.mkdir(parents=True, exist_ok=True)
        run(["npm", "install", "--silent", "--no-audit", "--no-fund", "--ignore-scripts", "--prefix", folder, *packages])
        done.write_text(" ".join(packages))
    return folder
