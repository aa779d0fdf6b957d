"""Compiles motorid's modules with the C compiler of the package ziglang, for any platform.

setup.py uses it where ``MOTORID_TARGET`` names a platform of TARGETS, and where this machine has
no C compiler. The modules use Python's stable ABI alone (include/Python.h). So they need neither
the headers of a Python nor its import library, and load in each Python from 3.11.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
INCLUDE = HERE / "include"
PYTHON_TAG, ABI_TAG = "cp311", "abi3"
FLAGS = (
    "-O3",
    "-DNDEBUG",
    "-DPy_LIMITED_API=0x030b0000",
    "-fvisibility=hidden",
    "-ffp-contract=off",  # clang fuses products and sums on arm64 unless told not to
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-sanitize=undefined",  # which zig adds by itself
    "-s",
)


class BuildError(Exception):
    """Nothing here can compile. The text says what to install."""


@dataclass(frozen=True)
class Target:
    """A platform: zig's name of it, the wheel's tag, and the suffix of a module."""

    zig: str
    wheel: str
    suffix: str = ".abi3.so"

    @property
    def kind(self) -> str:
        """linux, windows or macos."""
        return self.zig.split("-")[1].split(".")[0]


TARGETS = {
    "linux-x86_64": Target("x86_64-linux-gnu.2.17", "manylinux_2_17_x86_64.manylinux2014_x86_64"),
    "linux-aarch64": Target(
        "aarch64-linux-gnu.2.17", "manylinux_2_17_aarch64.manylinux2014_aarch64"
    ),
    "windows-x86_64": Target("x86_64-windows-gnu", "win_amd64", ".pyd"),
    "macos-x86_64": Target("x86_64-macos.11.0", "macosx_11_0_x86_64"),
    "macos-arm64": Target("aarch64-macos.11.0", "macosx_11_0_arm64"),
}
SYSTEMS = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}
MACHINES = {"amd64": "x86_64", "x86_64": "x86_64", "aarch64": "aarch64", "arm64": "aarch64"}


def host(system: str, machine: str) -> str:
    """The target that this machine is.

    Raises:
        BuildError: It is none of them.
    """
    cpu = MACHINES.get(machine.lower(), machine)
    name = f"{SYSTEMS.get(system, system)}-{cpu}".replace("macos-aarch64", "macos-arm64")
    if name not in TARGETS:
        raise BuildError(
            f"no C compiler is here, and ziglang builds for {', '.join(TARGETS)} but not for "
            f"{name}: install gcc and Python's headers"
        )
    return name


def asked() -> str:
    """The target that zig is to build for; "" where the machine's own compiler builds.

    Raises:
        BuildError: ``MOTORID_TARGET`` names none, or neither compiler is here.
    """
    name = os.environ.get("MOTORID_TARGET", "")
    if name and name not in TARGETS:
        raise BuildError(f"MOTORID_TARGET={name}: the targets are {', '.join(TARGETS)}")
    if name or has_compiler():
        return name
    return host(platform.system(), platform.machine())


def has_compiler() -> bool:
    """Whether this machine's compiler can build a module: it is there, and Python's headers are."""
    if sys.platform == "win32":
        return _has_visual_c()
    named = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    headers = Path(sysconfig.get_paths()["include"], "Python.h")
    return shutil.which(named.split()[0]) is not None and headers.exists()


def _has_visual_c() -> bool:
    if shutil.which("cl"):
        return True
    finder = Path(
        os.environ.get("ProgramFiles(x86)", ""),  # noqa: SIM112  # Windows spells it so
        "Microsoft Visual Studio/Installer/vswhere.exe",
    )
    if not finder.is_file():
        return False
    wanted = ("-latest", "-products", "*", "-requires", "Microsoft.VisualStudio.Workload.VCTools")
    said = subprocess.run(
        [finder, *wanted, "-property", "installationPath"], capture_output=True, text=True
    )
    return bool(said.stdout.strip())


def command() -> list[str]:
    """How zig is called.

    Raises:
        BuildError: It is not installed.
    """
    if importlib.util.find_spec("ziglang") is None:
        raise BuildError(
            "no C compiler with Python's headers is here, and the package ziglang is not: "
            "pip install ziglang, or install gcc and python3-dev"
        )
    return [sys.executable, "-m", "ziglang"]


def compile_module(
    target: Target, sources: Iterable[str], output: Path, folders: Sequence[str], work: Path
) -> None:
    """Links ``sources`` to the module ``output``.

    ``folders`` hold its headers; ``work`` gets what is only made on the way.

    Raises:
        BuildError: Zig is not installed, or it refuses the sources.
    """
    output.parent.mkdir(parents=True, exist_ok=True)
    words = [*command(), "cc", "-target", target.zig, "-shared", *FLAGS]
    words += ["-I", str(INCLUDE), *(f"-I{folder}" for folder in folders)]
    words += [*sources, "-o", str(output)]
    if target.kind == "windows":
        words += [str(_import_library(work))]
    else:
        words += ["-fPIC", "-lm"]
        words += ["-Wl,-undefined,dynamic_lookup"] if target.kind == "macos" else []
    _run(words)
    for rest in (output.with_suffix(".pdb"), output.with_suffix(".lib")):
        rest.unlink(missing_ok=True)  # what a linker for Windows leaves beside a module


def _import_library(work: Path) -> Path:
    """Of python3.dll, which has the stable ABI of every version of Python."""
    work.mkdir(parents=True, exist_ok=True)
    definition, library = work / "python3.def", work / "python3.lib"
    header = (INCLUDE / "Python.h").read_text(encoding="utf-8")
    functions = sorted(set(re.findall(r"\b(Py\w+)\(", header.rpartition("/* types */")[2])))
    exports = "\n".join(["  _Py_NoneStruct DATA", *(f"  {name}" for name in functions)])
    definition.write_text(f"LIBRARY python3.dll\nEXPORTS\n{exports}\n", encoding="ascii")
    tool = [*command(), "dlltool", "-m", "i386:x86-64"]
    _run([*tool, "-d", str(definition), "-l", str(library)])
    return library


def _run(words: Sequence[str]) -> None:
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"{' '.join(words[2:4])} failed:\n{done.stderr.strip()[-4000:]}")


if __name__ == "__main__":  # for tools/setup.sh: exit code 0 where no zig is needed
    sys.exit(not has_compiler())
