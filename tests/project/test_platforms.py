"""Every dependency has a wheel for every machine that people use, as a resolver finds it."""

import itertools
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
UV = shutil.which("uv", path=str(Path(sys.executable).parent))
UNREACHED = ("error sending request", "failed to fetch", "dns error", "timed out", "network")

MACHINES = {
    "linux x86_64": "x86_64-manylinux_2_28",
    "linux aarch64": "aarch64-manylinux_2_28",
    "darwin arm64": "aarch64-apple-darwin",
    "darwin x86_64": "x86_64-apple-darwin",
    "win32 AMD64": "x86_64-pc-windows-msvc",
    "win32 ARM64": "aarch64-pc-windows-msvc",
}
"""Machines, by `sys_platform` and `platform_machine`, and what uv calls them."""

WITHOUT_WHEELS = {("win32 ARM64", "3.11")}
"""numba begins with Python 3.12 there."""


def run_uv(folder, *words):
    """Run uv in a folder; skips where no index of packages is reached."""
    assert UV is not None, "uv is not installed: pip install -e '.[test]'"
    words = [UV, *words, "--quiet"]
    done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode and any(word in done.stderr.lower() for word in UNREACHED):
        pytest.skip(f"no index of packages: {done.stderr[-200:]}")
    return done


def project(folder, *edits):
    """Our own pyproject.toml in another folder, which asks for wheels for every machine."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    for old, new in edits:
        assert old in text
        text = text.replace(old, new)
    wanted = ["sys_platform == '{}' and platform_machine == '{}'".format(*machine.split()) for machine in MACHINES]
    asked = f"\n[tool.uv]\nrequired-environments = {wanted}\n"
    (folder / "pyproject.toml").write_text(text + asked, encoding="utf-8")
    shutil.copy(ROOT / "README.md", folder)
    (folder / "walkergen").mkdir()
    shutil.copy(ROOT / "walkergen" / "__init__.py", folder / "walkergen")
    return folder


@pytest.mark.slow
def test_a_resolver_finds_wheels_for_every_machine(tmp_path):
    done = run_uv(project(tmp_path), "lock")
    assert done.returncode == 0, done.stderr
    lock = (tmp_path / "uv.lock").read_text(encoding="utf-8")
    assert lock.count("\n[[package]]") > 50


@pytest.mark.slow
def test_the_resolver_notices_a_package_without_wheels_for_a_machine(tmp_path):
    marker = "; platform_machine == 'x86_64' or platform_machine == 'AMD64' or sys_platform == 'darwin'"
    done = run_uv(project(tmp_path, (marker, "")), "lock")
    assert done.returncode != 0
    assert "lib3mf" in done.stderr


@pytest.mark.nightly
@pytest.mark.parametrize(("machine", "python"), list(itertools.product(MACHINES, ("3.11", "3.12", "3.13", "3.14"))))
def test_a_resolver_finds_wheels_for_every_python(tmp_path, machine, python):
    done = run_uv(
        tmp_path,
        "pip",
        "compile",
        str(ROOT / "pyproject.toml"),
        "--only-binary",
        ":all:",
        "--python-platform",
        MACHINES[machine],
        "--python-version",
        python,
        "--no-header",
        "--output-file",
        str(tmp_path / "resolved.txt"),
    )
    assert (done.returncode == 0) == ((machine, python) not in WITHOUT_WHEELS), done.stderr
