"""Building without a C compiler, and for other platforms: all that needs no zig to be shown.

``make wheels`` builds and judges the wheels themselves.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

from tools.building import library, wheels, zig_build
from tools.building.zig_build import TARGETS, BuildError, Target

HEADER = zig_build.INCLUDE / "Python.h"
LIMITED = "-DPy_LIMITED_API=0x030b0000"
LINUX = TARGETS["linux-x86_64"]


def own_module(repo_root: Path, name: str) -> bytes:
    """A module as this machine's compiler built it."""
    return (repo_root / "motorid" / f"{name}.abi3.so").read_bytes()


@pytest.mark.slow
def test_our_header_says_what_pythons_own_says(tmp_path: Path) -> None:
    """A function declared twice in different ways is an error in C."""
    both = tmp_path / "both.c"
    both.write_text(f'#include <Python.h>\n#include "{HEADER}"\n', encoding="utf-8")
    real = f"-I{sysconfig.get_paths()['include']}"
    words = ["cc", "-fsyntax-only", "-Werror", LIMITED, real, str(both)]
    assert subprocess.run(words, capture_output=True).returncode == 0
    spoilt = HEADER.read_text(encoding="utf-8").replace(
        "PyLong_FromLong(long value)", "PyLong_FromLong(int value)"
    )
    both.write_text(f"#include <Python.h>\n{spoilt}", encoding="utf-8")
    assert b"PyLong_FromLong" in subprocess.run(words, capture_output=True).stderr


@pytest.mark.parametrize("name", ["motor/_batch", "motor/_response", "sim/_plant"])
def test_a_module_asks_python_for_nothing_but_what_the_header_has(
    name: str, repo_root: Path
) -> None:
    found = library.read(own_module(repo_root, name))
    assert found.kind == "linux"
    assert f"PyInit_{name.rpartition('/')[2]}" in found.offers
    python = {one for one in found.asks if one.startswith(("Py", "_Py"))}
    assert "PyImport_ImportModule" in python
    # what the macros of Python's own header call, where ours call Py_DecRef
    assert python - wheels.stable_abi() <= {"_Py_Dealloc"}


@pytest.mark.parametrize(
    ("system", "machine", "name"),
    [
        ("Linux", "x86_64", "linux-x86_64"),
        ("Linux", "aarch64", "linux-aarch64"),
        ("Windows", "AMD64", "windows-x86_64"),
        ("Darwin", "x86_64", "macos-x86_64"),
        ("Darwin", "arm64", "macos-arm64"),
    ],
)
def test_each_platform_is_its_target(system: str, machine: str, name: str) -> None:
    assert zig_build.host(system, machine) == name


def test_a_platform_without_wheels_is_told_what_to_install() -> None:
    with pytest.raises(BuildError, match=r"not for linux-mips: install gcc"):
        zig_build.host("Linux", "mips")


def test_zig_builds_where_no_compiler_is_or_where_it_is_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("MOTORID_TARGET", raising=False)
    assert zig_build.asked() == ""
    monkeypatch.setenv("MOTORID_TARGET", "macos-arm64")
    assert zig_build.asked() == "macos-arm64"
    monkeypatch.setenv("MOTORID_TARGET", "amiga")
    with pytest.raises(BuildError, match=r"MOTORID_TARGET=amiga: the targets are linux-x86_64,"):
        zig_build.asked()
    monkeypatch.delenv("MOTORID_TARGET")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert zig_build.asked() in TARGETS


def test_headers_of_python_count_as_much_as_the_compiler(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert zig_build.has_compiler()
    monkeypatch.setattr(sysconfig, "get_paths", lambda: {"include": str(tmp_path)})
    assert not zig_build.has_compiler()


def test_without_both_compilers_a_sentence_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(BuildError, match="pip install ziglang, or install gcc and python3-dev"):
        zig_build.command()


@pytest.mark.parametrize("name", TARGETS)
def test_every_target_is_compiled_without_fused_products(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[list[str]] = []
    monkeypatch.setattr(zig_build, "command", lambda: ["python", "-m", "ziglang"])
    monkeypatch.setattr(zig_build, "_run", lambda words: said.append(list(words)))
    target = TARGETS[name]
    zig_build.compile_module(target, ["a.c"], tmp_path / f"a{target.suffix}", ["inc"], tmp_path)
    compiled = said[-1] if target.kind != "windows" else next(w for w in said if "cc" in w)
    assert {"-ffp-contract=off", "-O3", "-Iinc", "a.c", target.zig} <= set(compiled)
    linked = {"windows": str(tmp_path / "python3.lib"), "macos": "-Wl,-undefined,dynamic_lookup"}
    for kind, word in linked.items():
        assert (word in compiled) == (target.kind == kind)
    if target.kind == "windows":
        definition = (tmp_path / "python3.def").read_text(encoding="ascii").split()
        assert {"PyImport_ImportModule", "_Py_NoneStruct", "PyObject_Free"} <= set(definition)


def wheel_of(folder: Path, target: Target, modules: dict[str, bytes]) -> Path:
    path = folder / f"motorid-1.0-cp311-abi3-{target.wheel}.whl"
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in modules.items():
            archive.writestr(name, data)
    return path


def test_a_wheel_is_judged_by_what_is_inside(tmp_path: Path, repo_root: Path) -> None:
    native = {
        module + LINUX.suffix: own_module(repo_root, module.removeprefix("motorid/"))
        for module in wheels.MODULES
    }
    found = list(wheels.faults(wheel_of(tmp_path, TARGETS["linux-aarch64"], native), LINUX))
    assert any("its tags are not those of manylinux_2_17_x86_64" in one for one in found)
    arm = TARGETS["linux-aarch64"]
    found = list(wheels.faults(wheel_of(tmp_path, arm, native), arm))
    assert sum("for linux on x86_64, not for linux on aarch64" in one for one in found) == 3
    # _Py_Dealloc is what Python's own header calls: this machine's modules are no release
    assert any("asks for _Py_Dealloc, which is not of Python's stable ABI" in one for one in found)
    mac = TARGETS["macos-arm64"]
    names = {"motorid/motor/_response.abi3.so": b"\x7fELF\x02", "motorid/sim/_plant.pyd": b""}
    found = list(wheels.faults(wheel_of(tmp_path, mac, names), mac))
    assert "motorid/motor/_batch.abi3.so is not in the wheel" in found
    assert any("_response.abi3.so: a library that is cut or unknown" in one for one in found)
    assert "motorid/sim/_plant.pyd is of another platform" in found


@pytest.mark.parametrize("data", [b"", b"MZ", b"\x7fELF\x02", b"\xcf\xfa\xed\xfe", b"PK\3\4" * 99])
def test_what_is_no_library_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="library"):
        library.read(data)


FAKE = """
import sys
words = sys.argv
open(words[words.index("-o" if "-o" in words else "-l") + 1], "wb").write(b"no library")
"""


@pytest.mark.slow
def test_a_wheel_for_another_platform_has_its_tags_and_its_suffixes(
    tmp_path: Path, repo_root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The whole way of ``make wheels``, with a compiler that writes nonsense: it is seen."""
    source = tmp_path / "source"
    for name in ("motorid", "rigs", "products", "tools/building", "locks"):
        shutil.copytree(
            repo_root / name, source / name, ignore=shutil.ignore_patterns("*.so", "__pycache__")
        )
    for name in ("setup.py", "pyproject.toml", "README.md", "LICENSE", "MANIFEST.in"):
        shutil.copy(repo_root / name, source / name)
    firmware = source / "firmware" / "build" / "release"
    firmware.mkdir(parents=True)
    (firmware / "motorid-uno.hex").write_text(":00000001FF\n", encoding="ascii")
    fake = source / "build" / "zig" / "ziglang"
    fake.mkdir(parents=True)
    (fake / "__init__.py").touch()
    (fake / "__main__.py").write_text(FAKE, encoding="utf-8")
    monkeypatch.setattr(wheels, "ROOT", source)
    monkeypatch.setattr(wheels, "ZIG", fake.parent)
    with pytest.raises(BuildError, match=r"_batch\.pyd: no ELF, PE or Mach-O library"):
        wheels.build("windows-x86_64", tmp_path / "dist")
    assert not (tmp_path / "dist").exists()
    (wheel,) = (source / "build" / "wheels" / "windows-x86_64" / "dist").glob("*.whl")
    assert wheel.name.endswith("-cp311-abi3-win_amd64.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert {"motorid/motor/_response.pyd", "motorid/rigs/sim.toml"} <= names
    assert "motorid/firmware/motorid-uno.hex" in names
    assert not [name for name in names if name.endswith(".so")]


@pytest.mark.slow
def test_a_build_asks_for_zig_only_without_a_compiler(repo_root: Path) -> None:
    """In an interpreter of its own: pip imports the backend by its bare name."""
    code = (
        "import sys; sys.path.insert(0, 'tools/building'); import backend, zig_build\n"
        "print(backend.compiler()); zig_build.has_compiler = lambda: False\n"
        "print(backend.compiler())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=repo_root, capture_output=True, text=True, check=True
    )
    first, second = done.stdout.splitlines()
    assert first == "[]"
    assert second.startswith("['ziglang==")
