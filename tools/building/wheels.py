"""Wheels for every platform, cross-compiled on this machine, with the boards' firmware inside.

    python -m tools.building.wheels [TARGET ...] [-o dist]

Without a TARGET: all of them. The compiler is ziglang, of the version and the hashes in
locks/zig.txt, installed into build/zig where it is not there. Each wheel is checked before it
counts: the processor of its modules, what they offer, and what they ask of a machine.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from tools.building import library
from tools.building.zig_build import INCLUDE, TARGETS, BuildError, Target

ROOT = Path(__file__).resolve().parent.parent.parent
ZIG = ROOT / "build" / "zig"
LOCK = ROOT / "locks" / "zig.txt"
MODULES = ("motorid/motor/_batch", "motorid/motor/_response", "motorid/sim/_plant")
FIRMWARE = ("motorid-mega.hex", "motorid-pico.uf2", "motorid-uno.hex", "SHA256SUMS")
COMPILERS = ("avr-gcc", "arm-none-eabi-gcc")
OLDEST_GLIBC = (2, 17)  # of the wheels' tag
WINDOWS_HAS = re.compile(r"python3\.dll|kernel32\.dll|api-ms-win-crt-[\w-]+\.dll", re.IGNORECASE)
MACOS_HAS = re.compile(r"/usr/lib/libSystem\.B\.dylib")


def build(name: str, folder: Path) -> Path:
    """The wheel for one target, built afresh and checked.

    Raises:
        BuildError: It cannot be built, or it is not what its name says.
    """
    work = ROOT / "build" / "wheels" / name
    shutil.rmtree(work, ignore_errors=True)
    made = work / "dist"
    words = [sys.executable, "setup.py", "-q", "build", "-b", str(work)]
    words += ["bdist_wheel", "-d", str(made), "--bdist-dir", str(work / "tree")]
    path = os.pathsep.join(filter(None, (str(ZIG), os.environ.get("PYTHONPATH", ""))))
    environment = {**os.environ, "MOTORID_TARGET": name, "MOTORID_RELEASE": "1"}
    done = subprocess.run(
        words, cwd=ROOT, env={**environment, "PYTHONPATH": path}, capture_output=True, text=True
    )
    if done.returncode:
        raise BuildError(f"{name}: {done.stderr.strip()[-4000:]}")
    (wheel,) = made.glob("*.whl")
    found = [f"{name}: {sentence}" for sentence in faults(wheel, TARGETS[name])]
    if found:
        raise BuildError("\n".join(found))
    folder.mkdir(parents=True, exist_ok=True)
    return Path(shutil.copy(wheel, folder / wheel.name))


def faults(wheel: Path, target: Target) -> Iterator[str]:
    """A sentence for each thing that a wheel for ``target`` should not be or lacks."""
    if not wheel.stem.endswith(f"-cp311-abi3-{target.wheel}"):
        yield f"{wheel.name}: its tags are not those of {target.wheel}"
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        for module in MODULES:
            file = module + target.suffix
            if file not in names:
                yield f"{file} is not in the wheel"
                continue
            for sentence in module_faults(module, archive.read(file), target):
                yield f"{file}: {sentence}"
        compiled = {name for name in names if name.endswith((".so", ".pyd", ".dll", ".dylib"))}
        for name in sorted(compiled - {module + target.suffix for module in MODULES}):
            yield f"{name} is of another platform"


def module_faults(module: str, data: bytes, target: Target) -> Iterator[str]:
    """The same for one compiled module."""
    try:
        found = library.read(data)
    except ValueError as error:
        yield str(error)
        return
    wanted = (target.kind, target.zig.split("-")[0])
    if (found.kind, found.machine) != wanted:
        yield f"it is for {found.kind} on {found.machine}, not for {' on '.join(wanted)}"
    entry = f"PyInit_{module.rpartition('/')[2]}"
    if entry not in found.offers:
        yield f"it has no entry point {entry}"
    python = {name for name in found.asks if re.match(r"_?Py[A-Z_]", name)}
    for name in sorted(python - stable_abi()):
        yield f"it asks for {name}, which is not of Python's stable ABI"
    for version in sorted(found.versions):
        number = tuple(int(part) for part in re.findall(r"\d+", version))
        if number > OLDEST_GLIBC:
            yield f"it needs {version}, newer than its tag says"
    has = WINDOWS_HAS if found.kind == "windows" else MACOS_HAS
    for name in sorted(found.libraries):
        if not has.fullmatch(name):
            yield f"it needs {name}, which not every machine has"


def stable_abi() -> set[str]:
    """The names that include/Python.h declares."""
    header = (INCLUDE / "Python.h").read_text(encoding="utf-8")
    return {"_Py_NoneStruct", *re.findall(r"\b(Py\w+)\(", header.rpartition("/* types */")[2])}


def get_zig() -> None:
    """Installs the locked ziglang into build/zig, if it is not there.

    Raises:
        BuildError: pip cannot.
    """
    if (ZIG / "ziglang" / "__main__.py").is_file():
        return
    print("installing the C compiler ziglang, as locked in locks/zig.txt", file=sys.stderr)
    words = [sys.executable, "-m", "pip", "install", "-q", "--require-hashes", "--no-deps"]
    words += ["--disable-pip-version-check", "--target", str(ZIG), "-r", str(LOCK)]
    if subprocess.run(words).returncode:
        raise BuildError("ziglang cannot be installed: see above")


def get_firmware() -> str:
    """Builds the boards' images where their compilers are. A sentence where some are absent."""
    if all(map(shutil.which, COMPILERS)):
        words = ["make", "-C", "firmware", "hex"]
        done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            raise BuildError(f"the firmware does not compile: {done.stderr.strip()[-2000:]}")
    release = ROOT / "firmware" / "build" / "release"
    absent = [name for name in FIRMWARE if not (release / name).is_file()]
    if not absent:
        return ""
    return (
        f"the wheels lack firmware ({', '.join(absent)}): install gcc-avr, avr-libc, "
        "gcc-arm-none-eabi and libnewlib-arm-none-eabi"
    )


def main(arguments: Sequence[str]) -> int:
    """Exit code 1 where a wheel cannot be built or is not what it should be."""
    parser = argparse.ArgumentParser(prog="tools.building.wheels", description=__doc__)
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "dist")
    asked = parser.parse_args(arguments)
    unknown = [name for name in asked.targets if name not in TARGETS]
    if unknown:
        parser.error(f"{unknown[0]} is none of {', '.join(TARGETS)}")
    try:
        get_zig()
        said = get_firmware()
        if said:
            print(said, file=sys.stderr)
        for name in asked.targets or TARGETS:
            print(f"wrote {build(name, asked.output)}")
    except BuildError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
