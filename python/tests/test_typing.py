"""The stubs: strict type checkers accept them, and they have what the module has."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import not_tested

HERE = Path(__file__).parent


def run(*args: str) -> None:
    module = args[0].split(".")[0]
    if importlib.util.find_spec(module) is None:
        not_tested(f"{module} is not installed")
    done = subprocess.run([sys.executable, "-m", *args], cwd=HERE, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("checker", [("mypy", "--strict"), ("pyright", "-p", "typed/pyrightconfig.json")])
def test_strict_checkers_accept_a_program(checker: tuple[str, ...]) -> None:
    run(*checker, *(["typed/right.py"] if checker[0] == "mypy" else ["--pythonpath", sys.executable]))


def test_strict_checkers_find_what_is_wrong() -> None:
    """The test of the test: each line of typed/wrong.py is an error."""
    if importlib.util.find_spec("mypy") is None:
        not_tested("mypy is not installed")
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "typed/wrong.py"], cwd=HERE, capture_output=True, text=True, check=False)
    wrong = [number for number, line in enumerate((HERE / "typed/wrong.py").read_text().splitlines(), 1) if "# wrong" in line]
    found = {int(line.split(":")[1]) for line in done.stdout.splitlines() if ": error:" in line}
    assert found == set(wrong), done.stdout


def test_the_stubs_have_what_the_module_has() -> None:
    run("mypy.stubtest", "gpu_stereo", "--ignore-missing-stub", "--allowlist", "typed/allowed.txt")


def test_the_keywords_are_those_of_the_table() -> None:
    sys.path.insert(0, str(HERE.parent))
    try:
        spec = importlib.util.spec_from_file_location("options_of_the_table", HERE.parent / "tools" / "options.py")
        assert spec and spec.loader
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        written = (HERE.parent / "gpu_stereo" / "_options.py").read_text()
        assert module.written() == written, "python python/tools/options.py > python/gpu_stereo/_options.py"
    finally:
        sys.path.pop(0)
