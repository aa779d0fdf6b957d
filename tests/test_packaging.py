"""The wheel works in an environment of its own, from any folder."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import venv
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest

from motorid.web.pages import FILES

pytestmark = [pytest.mark.slow, pytest.mark.long]
SITE_PACKAGES = "import sysconfig; print(sysconfig.get_path('purelib'))"


def run(*command: str | Path, cwd: Path, env: Mapping[str, str] | None = None) -> str:
    """The standard output of a command that must succeed."""
    words = list(map(str, command))
    done = subprocess.run(words, cwd=cwd, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.strip()


def copy_of_source(repo_root: Path, target: Path) -> Path:
    """The files under version control, without what was built among them."""
    for name in filter(None, run("git", "ls-files", "-z", cwd=repo_root).split("\0")):
        if (repo_root / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            (target / name).write_bytes((repo_root / name).read_bytes())
    return target


def hasty(folder: Path) -> dict[str, str]:
    """This environment with a C compiler that does not optimise, which takes most of a build.

    The other tests run what was built as users have it.
    """
    usual = os.environ.get("CC") or shutil.which("cc")
    if sys.platform == "win32" or not usual:
        return dict(os.environ)
    compiler = folder / "cc"
    compiler.write_text(f'#!/bin/sh\nexec {usual} "$@" -O0\n')
    compiler.chmod(0o755)
    return os.environ | {"CC": str(compiler)}


@pytest.fixture(scope="module")
def wheel(repo_root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    source = copy_of_source(repo_root, tmp_path_factory.mktemp("source"))
    wheels = tmp_path_factory.mktemp("wheels")
    build = ("wheel", "-q", "--no-deps", "--no-build-isolation", "-w", wheels, source)
    compiler = hasty(tmp_path_factory.mktemp("compiler"))
    run(sys.executable, "-m", "pip", *build, cwd=source, env=compiler)
    (built,) = wheels.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def motorid(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The command in a fresh environment that holds the wheel and borrows its dependencies."""
    home = tmp_path_factory.mktemp("environment")
    venv.create(home, with_pip=False)
    commands = home / ("Scripts" if sys.platform == "win32" else "bin")
    install = ("--python", commands / "python", "install", "-q", "--no-deps", wheel)
    run(sys.executable, "-m", "pip", *install, cwd=home)
    theirs = Path(run(commands / "python", "-c", SITE_PACKAGES, cwd=home))
    ours = run(sys.executable, "-c", SITE_PACKAGES, cwd=home)
    # The wheel comes first on the path; of a borrowed folder no .pth is read, so that this
    # environment's editable motorid stays out.
    (theirs / "borrowed.pth").write_text(f"{ours}\n", encoding="utf-8")
    where = run(commands / "python", "-c", "import motorid; print(motorid.__file__)", cwd=home)
    assert Path(where).is_relative_to(home)
    return commands / "motorid"


def test_wheel_holds_rigs_spec_and_types_but_no_tests(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    needed = {"motorid/rigs/sim.toml", "motorid/wire/spec.toml", "motorid/py.typed"}
    needed |= {f"motorid/web/page/{name}" for name in FILES}
    needed |= {"motorid/rigs/instruments/scpi.toml"}
    assert needed <= set(names)
    assert [name for name in names if name.endswith("licenses/motorid/web/page/uPlot.LICENSE")]
    assert not [name for name in names if name.startswith(("tests/", "bench/", "tools/"))]


def test_command_works_from_any_folder(motorid: Path, tmp_path: Path) -> None:
    assert "Look and fit:" in run(motorid, "--help", cwd=tmp_path)
    assert "sim" in run(motorid, "rigs", cwd=tmp_path).split()


def test_whole_way_from_any_folder(motorid: Path, tmp_path: Path) -> None:
    table = run(motorid, "run", "--rig", "sim", "--speed", "max", "-o", "out", cwd=tmp_path)
    assert "N·m/A" in table
    files = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"capture.h5", "estimate.json", "report.html"} <= files
    estimate = json.loads((tmp_path / "out" / "estimate.json").read_text(encoding="utf-8"))
    assert set("RLKBJ") | {"T0"} <= set(estimate["parameters"])
