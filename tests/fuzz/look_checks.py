"""What a look at a text table promises of any bytes: a proposal that imports, or one sentence."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path

import motorid.capture.csv_reader  # noqa: F401 - imported late by the look, too late to be seen
from motorid.capture.table import read_table
from motorid.capture.table_options import TableOptions
from motorid.errors import DataError, UsageError
from motorid.workflow.proposal.page import asked, page
from motorid.workflow.proposal.proposal import look, propose
from motorid.workflow.proposal.question import NOTHING
from tests.fuzz.csv_checks import CORPUS, MEMORY
from tests.fuzz.sentence import check_sentence

_folder = tempfile.TemporaryDirectory(
    prefix="motorid-fuzz-", dir=MEMORY if MEMORY.is_dir() else None
)
_path = Path(_folder.name, f"look{os.getpid()}.csv")
MOST = 8  # answers that are given; each settles something


def check(data: bytes) -> None:
    """Raises where a table breaks a promise. Its first byte chooses among the answers."""
    _path.write_bytes(data[1:])
    choice = data[0] if data else 0
    try:
        with warnings.catch_warnings(action="error"):
            _look(choice, len(data))
    except (DataError, UsageError) as error:
        check_sentence(str(error), len(data))


def _look(choice: int, size: int) -> None:
    known, table = NOTHING, look(_path, TableOptions())
    for _ in range(MOST):
        found = propose(table, known)
        assert page(found)
        if not found.questions:
            break
        question = found.questions[0]
        assert asked(question)
        count = len(question.answers)
        number = question.number is not None and (not count or choice % 3 == 0)
        if not number and not count:
            return
        known = known.and_(
            question.of_number(0.01) if number else question.answers[choice % count].known
        )
    if found.questions or not found.maps:
        return
    counts = found.counts_per_turn
    capture = read_table(_path, found.maps, counts_per_turn=counts)
    assert 0 < len(capture) <= size


def seeds() -> Iterator[bytes]:
    """The tables kept, with several choices of answers."""
    for path in sorted(CORPUS.glob("*")):
        for choice in (0, 1, 2):
            yield bytes([choice]) + path.read_bytes()
