"""Exit codes of a fit whose values are doubtful or not supported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bench.spoilt import made
from motorid.capture import store
from motorid.cli.main import run
from motorid.errors import EXIT_DATA, EXIT_DONE
from motorid.estimate.assembly.doubt import settled
from motorid.estimate.assembly.refusal import refused
from motorid.estimate.model.unexplained import Unexplained
from motorid.estimate.results.estimate import Suspect
from motorid.workflow.fit import exit_code
from tests.report.example import estimate


def test_a_doubtful_value_ends_with_4_where_that_is_asked_for() -> None:
    lag = Suspect("current_lag", "current", "it is late", "declare it", "named", {"R": 1.0})
    doubted = settled(estimate(), [lag])
    assert exit_code(doubted) == EXIT_DONE
    assert exit_code(doubted, strict=True) == EXIT_DATA
    assert exit_code(estimate(), strict=True) == EXIT_DONE


def test_values_that_are_not_supported_end_with_4_always() -> None:
    assert exit_code(refused(estimate(), Unexplained("current", 0.9, 0.9, False))) == EXIT_DATA


@pytest.mark.slow
def test_a_refused_capture_leaves_its_report_and_a_4(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    spoilt = made("log-position", "voltage shuffled", "sim", np.random.default_rng(0))
    store.save(spoilt.capture, tmp_path / "run.h5")
    line = ["fit", str(tmp_path / "run.h5"), "--model", "six", "-o", str(tmp_path / "out")]
    assert run(line) == EXIT_DATA
    printed = capfd.readouterr().out
    assert printed.lstrip().startswith("✗ No motor gives these readings together")
    assert "not supported" in printed
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"estimate.json", "report.html"}
