"""The wire's promises on every input kept, and on what a fuzzer finds in a few seconds."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.fuzz.wire_checks import check, corpus


def test_corpus_holds() -> None:
    inputs = corpus()
    assert len(inputs) > 60
    for data in inputs:
        check(data)


@pytest.mark.slow
def test_fuzzer_finds_nothing(repo_root: Path, tmp_path: Path) -> None:
    pytest.importorskip("atheris", reason="no atheris: the fuzzer is not installed")
    done = subprocess.run(
        [sys.executable, "-m", "tests.fuzz.fuzz_wire", "--seconds", "5", "--found", str(tmp_path)],
        capture_output=True,
        text=True,
        cwd=repo_root,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert "Done " in done.stderr
