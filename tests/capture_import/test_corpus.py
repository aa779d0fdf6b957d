"""A corpus of foreign files: a proposal is right in every quantity, unit and row, or it asks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motorid.capture.model import Capture
from motorid.capture.table import read_table
from motorid.capture.table_options import TableOptions
from motorid.workflow.proposal.proposal import Proposal, look, propose
from motorid.workflow.proposal.question import NOTHING, Known
from tests.capture_import.corpus.bench_log import NOISE, log
from tests.capture_import.corpus.files import FILES, File
from tests.capture_import.corpus.instruments import COUNTS

NAMES = {"terminal_voltage": "voltage"}
# a file keeps three decimals or more of V, A and ms, and one of rpm
WITHIN = {"voltage": 0.006, "current": 6e-4, "speed": 0.006, "position": 1e-4}
ASKED = {  # what a person says of the files that leave something open
    "hantek.csv": Known(
        {"terminal_voltage": "ch1", "current": "ch2"}, {"terminal_voltage": "V", "current": "A"}
    ),
    "row_numbers.csv": Known({"time": "row*0.002"}, {"time": "s"}),
    "swapped.csv": Known({"terminal_voltage": "current_A", "current": "voltage_V"},
                         {"terminal_voltage": "V", "current": "A"}),
}  # fmt: skip


def proposed(path: Path, known: Known = NOTHING) -> Proposal:
    return propose(look(path, TableOptions(counts_per_turn=known.counts_per_turn)), known)


def imported(path: Path, proposal: Proposal) -> Capture:
    return read_table(
        path, proposal.maps, counts_per_turn=proposal.counts_per_turn,
        sense=proposal.sense or "terminals",
    )  # fmt: skip


def insist_on_the_log(capture: Capture, name: str) -> None:
    """Every row is there, at its time, and each quantity in SI units as it was."""
    true = log()
    if name == "logic.csv":  # a row for each edge, at its moment
        turns = np.interp(capture.time_s, true["time"], true["position"]) / (2.0 * np.pi)
        read = capture.channels["position"].values / (2.0 * np.pi)
        assert np.abs(turns - read).max() < 1.1 / COUNTS
        return
    assert len(capture) == len(true["time"]), name
    np.testing.assert_allclose(capture.time_s, true["time"], atol=2e-6, err_msg=name)
    for quantity, channel in capture.channels.items():
        wanted = NAMES.get(quantity, quantity)
        if wanted in true:
            np.testing.assert_allclose(
                channel.values, true[wanted], atol=WITHIN[wanted], rtol=1e-4, err_msg=name
            )


@pytest.mark.slow
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_proposal_is_right_or_asks(file: File, tmp_path: Path) -> None:
    path = tmp_path / file.name
    file.make(path)
    found = proposed(path, file.known)
    assert bool(found.questions) == file.asks, [q.text for q in found.questions]
    if file.asks:
        found = proposed(path, ASKED[file.name])
        assert not found.questions
    capture = imported(path, found)
    assert len(capture) == found.table.rows
    insist_on_the_log(capture, file.name)
    assert file.quantities <= {NAMES.get(name, name) for name in capture.channels}


def test_nine_in_ten_take_one_confirmation() -> None:
    assert len(FILES) >= 30
    assert sum(file.asks for file in FILES) <= len(FILES) // 10
    assert NOISE.keys() <= log().keys()
