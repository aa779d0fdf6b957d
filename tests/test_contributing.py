"""What CONTRIBUTING leads a newcomer through works: its files, changes and commands, in order."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from motorid import program, rig_calibration
from motorid.acquire import journal
from motorid.capture import store_layout
from motorid.quality import records
from motorid.quality.history import schema
from motorid.report import agreement, json_, power
from motorid.storage import pack
from motorid.version import __version__
from motorid.wire import spec

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
STEP = re.compile(
    r"^<!-- (?P<kind>file|change|run)(?:: (?P<path>\S+))? -->\n```\w+\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
NEEDED = ("motorid", "tools", "docs", "pyproject.toml")
TESTS = ("__init__.py", "conftest.py", "exact_capture.py", "motor_reference.py")


def steps(page: str) -> Iterator[tuple[str, str, str]]:
    """Kind, path and text of every marked block."""
    return ((found["kind"], found["path"] or "", found["text"]) for found in STEP.finditer(page))


def changed(text: str, diff: str) -> str:
    """With the lines of a block that begin with "+". Raises AssertionError where its other lines
    are not in the text exactly once.
    """
    lines = diff.splitlines(keepends=True)
    before = "".join(line[1:] for line in lines if not line.startswith("+"))
    after = "".join(line[1:] for line in lines if not line.startswith("-"))
    assert text.count(before) == 1, before
    return text.replace(before, after)


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """A copy of the package that may be changed, with the environment of this one."""
    for name in NEEDED:
        if (ROOT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, tmp_path / name, ignore=ignored)
        else:
            shutil.copyfile(ROOT / name, tmp_path / name)
    (tmp_path / "tests" / "estimate").mkdir(parents=True)
    for name in TESTS:
        if (ROOT / "tests" / name).exists():
            shutil.copyfile(ROOT / "tests" / name, tmp_path / "tests" / name)
    (tmp_path / ".venv").symlink_to(sys.prefix)
    return tmp_path


@pytest.mark.slow
def test_the_example_of_an_influence_quantity_works(copied: Path) -> None:
    done = []
    for kind, path, text in steps(PAGE):
        if kind == "run":
            run(text, copied)
        elif kind == "file":
            assert not (copied / path).exists()
            (copied / path).write_text(text, encoding="utf-8")
        else:
            before = (copied / path).read_text(encoding="utf-8")
            (copied / path).write_text(changed(before, text), encoding="utf-8")
        done.append(kind)
    assert done == ["file", "change", "change", "file", "run"]
    page = (copied / "docs" / "influence-quantities.md").read_text(encoding="utf-8")
    assert "| current curvature | 1/A | motor | estimated | reading (current) |" in page


def test_the_table_of_versions_is_that_of_the_code() -> None:
    wire = spec.load()
    own = {agreement.AGREEMENT_SCHEMA, agreement.STATIONS_SCHEMA, power.POWER_SCHEMA}
    (ours,) = {schema_.rpartition("-")[2] for schema_ in own}
    for format_, version in {
        "package": __version__,
        "estimate JSON": json_.SCHEMA.rpartition("-")[2],
        "verdict, gauge and trend JSON": records.SCHEMA.rpartition("-")[2],
        "agreement, stations and power JSON": ours,
        "capture": f"{store_layout.MAJOR}.{store_layout.MINOR}",
        "program": str(program.VERSION),
        "journal": journal.MAGIC.decode().split()[-1],
        "index of a pack": pack.SCHEMA.rpartition("-")[2],
        "calibration file": rig_calibration.FORMAT.split()[-1],
        "wire": f"{wire.major}.{wire.minor}",
        "history": schema.VERSION,
    }.items():
        assert f"\n| {format_} | {version} |" in PAGE, format_


def test_the_rooms_are_those_of_the_contracts() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    whole, estimator, *_ = contracts["tool"]["importlinter"]["contracts"]
    names = set(re.findall(r"\w+", " ".join(whole["layers"])))
    rows = "\n".join(line for line in PAGE.splitlines() if line.startswith("| `"))
    told = {name.strip("/*") for name in re.findall(r"`([\w*]+)(?:\.py|/)`", rows)}
    assert {
        name for name in names if name not in told and name.partition("_")[0] not in told
    } == set()
    order = re.findall(r"^\| `(\w+)/` \|", PAGE.split("The estimator's rooms")[1], re.MULTILINE)
    assert order[: len(estimator["layers"])] == estimator["layers"][::-1]


def run(commands: str, where: Path) -> None:
    """In a shell that ends at the first command that fails."""
    environment = {**os.environ, "PYTHONPATH": str(where), "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("PYTEST_ADDOPTS", None)
    ran = subprocess.run(
        ["sh", "-e", "-c", commands], cwd=where, env=environment, capture_output=True, text=True
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr


def test_a_change_that_does_not_fit_is_refused() -> None:
    assert changed("a\nb\n", " a\n+c\n") == "a\nc\nb\n"
    with pytest.raises(AssertionError):
        changed("a\nb\n", " b\n+c\n a\n")
