"""The checks of lock and licences see what is wrong, and the bill of materials is whole."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tools.supply import bill, licences, lock, packages
from tools.supply.packages import SupplyError


@pytest.fixture
def locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Copies of the lock files that a test may spoil."""
    for what, path in packages.LOCKS.items():
        copy = tmp_path / path.name
        copy.write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
        monkeypatch.setitem(packages.LOCKS, what, copy)
    return tmp_path


def spoil(file: Path, old: str, new: str) -> None:
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")


def block(file: Path, name: str) -> str:
    """The lines of one package."""
    text = file.read_text(encoding="utf-8")
    begin = text.index(f"\n{name}==") + 1
    return text[begin : text.index("\n    # via", begin) + 1]


@pytest.mark.slow
def test_lock_pyproject_and_environment_agree(locks: Path) -> None:
    assert list(lock.faults()) == []


@pytest.mark.slow
def test_a_package_that_is_not_locked_is_seen(locks: Path) -> None:
    spoil(locks / "run.txt", block(locks / "run.txt", "h5py"), "")
    assert "h5py: needed, but not in locks/run.txt" in list(lock.faults())


@pytest.mark.slow
def test_another_version_than_the_installed_one_is_seen(locks: Path) -> None:
    for name in ("run.txt", "test.txt"):
        version = block(locks / name, "click").split()[0]
        spoil(locks / name, version, "click==7.0")
    found = list(lock.faults())
    assert any("is installed, 7.0 is locked" in one for one in found)
    assert any("click 7.0: locks/run.txt does not meet click>=" in one for one in found)


def test_the_compilers_lock_is_of_the_version_that_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = tmp_path / packages.COMPILER_LOCK.name
    copy.write_text(packages.COMPILER_LOCK.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(lock, "COMPILER_LOCK", copy)
    assert list(lock.compiler_faults()) == []
    version = copy.read_text(encoding="utf-8").split()[0]
    spoil(copy, version, "ziglang==0.1")
    assert list(lock.compiler_faults()) == [f"ziglang 0.1: locks/zig.txt is not {version}"]
    spoil(copy, "ziglang==0.1", "lead==0.1")
    assert len(list(lock.compiler_faults())) == 2


@pytest.mark.slow
def test_what_runs_and_what_is_tested_are_the_same_files(locks: Path) -> None:
    first = next(
        line for line in block(locks / "run.txt", "numpy").splitlines() if "sha256" in line
    )
    spoil(locks / "run.txt", f"{first}\n", "")
    assert list(lock.faults()) == ["numpy: locks/run.txt and locks/test.txt differ"]


@pytest.mark.slow
def test_what_nothing_needs_is_seen(locks: Path) -> None:
    for name in ("run.txt", "test.txt"):
        with (locks / name).open("a", encoding="utf-8") as file:
            file.write(f"leftpad==1.0 \\\n    --hash=sha256:{'0' * 64}\n")
    assert "leftpad: in locks/run.txt, but nothing needs it" in "\n".join(_until_error())


def _until_error() -> list[str]:
    found = []
    with pytest.raises(SupplyError, match="leftpad is not installed"):
        found.extend(lock.faults())
    return found


@pytest.mark.parametrize("line", ["numpy==2.4.6", "numpy>=2 --hash=sha256:" + "0" * 64])
def test_a_line_without_hash_or_version_is_refused(line: str, tmp_path: Path) -> None:
    (tmp_path / "run.txt").write_text(line + "\n", encoding="utf-8")
    with pytest.raises(SupplyError, match="no exact version with its hashes"):
        packages.pins(tmp_path / "run.txt")


@pytest.mark.slow
def test_every_installed_package_has_an_allowed_licence() -> None:
    assert list(licences.faults()) == []


@pytest.mark.parametrize(
    ("expression", "where", "may"),
    [
        ("MIT", "run", True),
        ("LGPL-3.0-only", "run", False),
        ("LGPL-3.0-only", "extra", True),
        ("GPL-3.0-or-later", "extra", False),
        ("GPL-3.0-or-later OR MIT", "run", True),
        ("GPL-3.0-or-later AND MIT", "run", False),
        ("BSD-3-Clause AND (MIT OR GPL-2.0-only)", "run", True),
        ("GPL-3.0-or-later WITH GCC-exception-3.1", "run", False),
    ],
)
def test_what_is_allowed_where(expression: str, where: str, may: bool) -> None:
    assert licences.allowed(expression, where) is may


@pytest.mark.slow
def test_a_package_without_a_stated_licence_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(licences.table(), "read", {})
    found = list(licences.faults())
    assert any(one.startswith("pyserial: no SPDX licence") for one in found)


@pytest.fixture(scope="module")
def document() -> bill.Json:
    return bill.bill()


@pytest.mark.slow
def test_the_bill_obeys_its_schema_and_comes_again(document: bill.Json) -> None:
    assert json.loads(bill.written(document)) == document == bill.bill()
    with pytest.raises(SupplyError, match="breaks its schema"):
        bill.written({**document, "components": [{"type": "library"}]})


@pytest.mark.slow
def test_the_bill_has_every_package_and_its_edges(document: bill.Json) -> None:
    named = {one["name"]: one for one in document["components"]}
    assert {"numpy", "scipy", "h5py", "avr-libc", "libgcc"} <= named.keys()
    assert named["numpy"]["scope"] == "required"
    assert named["pyarrow"]["scope"] == "optional"
    assert named["pytest"]["scope"] == "excluded"
    locked = packages.pins(packages.LOCKS["test"])
    assert locked.keys() - named.keys() == {n for n, pin in locked.items() if not pin.applies}
    edges = {one["ref"]: one["dependsOn"] for one in document["dependencies"]}
    assert "numpy" in edges["scipy"]
    assert {name for ends in edges.values() for name in ends} <= named.keys()


@pytest.mark.slow
def test_the_notices_hold_the_licences_of_what_users_install() -> None:
    text = "".join(bill.notices())
    assert "numpy" in text
    assert "Redistribution and use in source and binary forms" in text
    assert "pytest" not in [line.split()[0] for line in text.splitlines() if line.endswith("ed)")]
