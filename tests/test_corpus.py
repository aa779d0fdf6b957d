"""Files that older versions wrote are read, fitted, recovered and judged by this one."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import motorid
from motorid import json_seal
from motorid.acquire.record import recover
from motorid.capture import store
from motorid.cli.main import run
from motorid.quality.history import open_history

OLD = Path(__file__).resolve().parent / "corpus" / "format_1_0"


@pytest.mark.slow
def test_a_capture_of_format_1_0_is_read_and_fitted() -> None:
    capture = store.load(OLD / "run.h5")
    assert (len(capture), capture.content_sha256) == (1520, "")
    found = motorid.fit(OLD / "run.h5").parameters
    was = json.loads((OLD / "estimate.json").read_text(encoding="utf-8"))["parameters"]
    for name, parameter in found.items():
        assert parameter.value is not None
        off = abs(parameter.value - was[name]["value"])
        assert off < was[name]["uncertainty"]["total"], name


@pytest.mark.slow
def test_a_journal_of_format_1_0_gives_the_capture_that_it_gave(tmp_path: Path) -> None:
    shutil.copy(OLD / "cut.h5.journal", tmp_path)
    found, was = store.load(recover(tmp_path / "cut.h5.journal")), store.load(OLD / "run.h5")
    np.testing.assert_array_equal(found.ticks, was.ticks)
    for name, channel in was.channels.items():
        np.testing.assert_array_equal(found.channels[name].raw, channel.raw)
    assert found.content_sha256


def test_documents_of_minor_0_are_read() -> None:
    for name in ("estimate.json", "verdict.json"):
        document = json_seal.read(OLD / name, "a document")
        assert not json_seal.carries_digest(document)
        assert document["schema"].endswith("-1")


def test_an_old_history_is_listed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "line.db"
    shutil.copy(OLD / "line.db", path)
    with open_history(path, create=False) as history:
        assert [row.serial for row in history.results()] == ["D000017"]
    assert run(["history", "list", str(path)]) == 0
    assert "D000017" in capfd.readouterr().out
