"""The notebooks run from their first cell to their last, on one simulated run."""

from __future__ import annotations

import os
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

import motorid
from motorid.workflow.record import bench
from tests.acquire.rigs import SHORT

FOLDER = Path(__file__).resolve().parent.parent / "docs" / "notebooks"
ROLES = ("bench", "data", "line")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short one: the log that a notebook makes of it is fitted in seconds."""
    path = tmp_path_factory.mktemp("run") / "run.h5"
    rig = replace(bench("sim", speed="max"), program=SHORT)
    return motorid.record(rig, path, serial="D000001")


def test_each_role_has_one_and_none_is_kept_with_its_answers() -> None:
    assert sorted(path.stem for path in FOLDER.glob("*.ipynb")) == sorted(ROLES)
    for role in ROLES:
        book = nbformat.read(FOLDER / f"{role}.ipynb", as_version=4)
        nbformat.validate(book)
        assert [c for c in book.cells if c.cell_type == "code" and c.outputs] == []
        assert book.cells[0].source.startswith("# ")


@pytest.mark.slow
@pytest.mark.parametrize("role", ROLES)
def test_a_notebook_runs(
    role: str, run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cell that raises ends the run, and with it the test."""
    shutil.copy(run, tmp_path / "run.h5")
    monkeypatch.setenv(
        "PATH", os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))
    )
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    book = nbformat.read(FOLDER / f"{role}.ipynb", as_version=4)
    NotebookClient(
        book, timeout=600, startup_timeout=300, resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    shown = [
        output.data
        for cell in book.cells
        if cell.cell_type == "code"
        for output in cell.outputs
        if output.output_type == "execute_result"
    ]
    assert any("text/html" in data for data in shown)
    failed = [o for c in book.cells for o in c.get("outputs", ()) if o.output_type == "error"]
    assert failed == []
    if role != "line":
        assert any("<svg" in data.get("text/html", "") for data in shown)
