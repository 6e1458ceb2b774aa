"""Compiled kernels: in wheels by `make wheel`, and in the cache of who installs an editable copy.

Those of a wheel are the ones that the commands below compile, for any CPU of a kind; they lie in
walkergen/kernels, and `walkergen/core/numerics/shipped_kernels.py` says when they are used. A build with
WALKERGEN_KERNELS=all or =first makes one. `pip install -e .` compiles them for this machine, unless
WALKERGEN_KERNELS=none is set.
"""

import functools
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SHORT = ("--seconds", "0.05", "--runs", "2", "--quiet")
FIRST = (("simulate", *SHORT),)
CROWD = ("crowd", "--count", "2", "--seconds", "0.05", "--rate-hz", "100", "--runs", "1", "--no-pictures", "--quiet")
MORE = (
    ("family", "--no-pictures", "--quiet"),
    CROWD,
    ("calibrate", "drop", "--measured", "0.5", "--measured-sd", "0.05", "--drops", "2", "--quiet"),
    ("movie", "--periods", "2", "--fps", "10", "--quiet"),
    ("simulate", "coinbot", *SHORT),
)
"""Commands whose kernels a wheel takes along: those of WALKERGEN_KERNELS=first, and of all."""


class KernelsHook(BuildHookInterface):  # type: ignore[misc,type-arg]
    """Takes kernels along where the environment asks for them: a wheel of one platform then."""

    def initialize(self, version: str, build_data: dict) -> None:  # type: ignore[type-arg]
        """Compile kernels before the wheel is packed, or an editable copy is installed."""
        wished = os.environ.get("WALKERGEN_KERNELS", "")
        if version == "editable" and wished != "none":
            warm(Path(self.root))
        if self.target_name != "wheel" or version != "standard" or wished in ("", "none"):
            return
        commands = {"first": FIRST, "all": (*FIRST, *MORE)}[wished]
        folder = Path(self.root) / "build" / "kernels"
        shutil.rmtree(folder, ignore_errors=True)
        compile_into(folder, Path(self.root), commands)
        build_data["force_include"][str(folder)] = "walkergen/kernels"
        build_data["pure_python"] = False
        build_data["infer_tag"] = True


def warm(root: Path) -> None:
    """Compile the kernels of every command into the user's cache, those of crowds beside the others.

    A failed command compiles its kernels when it is first used.
    """
    others = [*FIRST, *(words for words in MORE if words != CROWD)]
    with ThreadPoolExecutor() as pool:
        list(pool.map(functools.partial(_run_commands, root), ([CROWD], others)))


def _run_commands(root: Path, commands: Sequence[tuple[str, ...]]) -> None:
    """Run commands one after the other, each in an empty folder, and print why one failed."""
    paths = [str(root), *filter(None, [os.environ.get("PYTHONPATH")])]  # where pip puts what builds need
    for words in commands:
        with tempfile.TemporaryDirectory() as place:
            done = subprocess.run(
                [sys.executable, "-m", "walkergen", *words],
                cwd=place,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
            )
        if done.returncode:
            reason = done.stderr.strip().splitlines()[-1:]
            print(f"{words[0]} will compile its kernels when it is first used: {''.join(reason)}", file=sys.stderr)


def compile_into(folder: Path, root: Path, commands: tuple[tuple[str, ...], ...]) -> None:
    """Compile what the commands need for CPUs of this kind, and write it with its manifest."""
    sys.path.insert(0, str(root))
    from walkergen.core.numerics import kernels, shipped_kernels

    own = shipped_kernels.machine_kind(kernels.source_digest())
    if not own.cpu:
        raise SystemExit("this CPU is no x86-64-v3: wheels with kernels are made on one that is")
    with tempfile.TemporaryDirectory() as place:
        cache = Path(place) / "numba"
        settings = {
            "NUMBA_CACHE_DIR": str(cache),
            "NUMBA_CPU_NAME": own.cpu,
            "NUMBA_CPU_FEATURES": "",
            "PYTHONPATH": str(root),
        }
        for words in commands:
            print(f"compiling for {' '.join(words)}", file=sys.stderr)
            subprocess.run(
                [sys.executable, "-m", "walkergen", *words],
                cwd=place,
                check=True,
                env=os.environ | settings,
                stdout=subprocess.DEVNULL,
            )
        sums = _gathered(cache, folder, root / "walkergen")
    manifest = own._asdict() | {"files": sums}
    (folder / shipped_kernels.MANIFEST).write_text(json.dumps(manifest, indent=1, sort_keys=True))


def _gathered(cache: Path, folder: Path, package: Path) -> dict[str, str]:
    """Copy entries of the package's rooms out of a cache; their sums by their names."""
    from walkergen.core import caches
    from walkergen.core.numerics import shipped_kernels

    rooms = {caches.cache_subpath(room): room for room in package.rglob("*") if room.is_dir()}
    sums = {}
    for path in sorted(cache.rglob("*.nb[ic]")):
        place = rooms[path.parent.name].relative_to(package) / path.name
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, folder / place)
        sums[place.as_posix()] = shipped_kernels.file_checksum(path)
    return sums
