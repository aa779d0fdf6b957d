"""A timeline's parts and its period where a program or a log says little."""

from __future__ import annotations

from dataclasses import replace

import pytest

from motorid.capture.model import Phase
from motorid.errors import DataError
from motorid.estimate.signals.time_grid import FINER, FINER_GRID, Part, lay
from motorid.program import StepKind
from tests.estimate.signals.test_time_grid import COAST, EVEN, capture, drive


def test_a_fit_may_ask_for_a_finer_grid_of_a_log() -> None:
    log = capture(EVEN)
    asked = lay(replace(log, provenance={FINER_GRID: 3}))
    assert asked.period_s == pytest.approx(1e-4 / FINER / 3)
    assert asked.count == 3 * 4 * 39 + 2
    assert asked.coarser == pytest.approx(1.0)


def test_stamps_of_a_log_that_stay_do_not_advance() -> None:
    twice = EVEN.copy()
    twice[7] = twice[6]
    with pytest.raises(DataError, match="do not advance"):
        lay(capture(twice))


def test_a_program_that_has_not_begun_leaves_one_part() -> None:
    whole = (Part(0, 40),)
    assert lay(capture(EVEN, drive(0.5), starts=())).parts == whole
    assert lay(capture(EVEN, drive(0.5), starts=(3900,))).parts == whole
    assert lay(capture(EVEN, drive(0.5), starts=(3800,))).parts[0].kind == StepKind.DRIVE_DUTY


def test_a_phase_of_no_step_is_none() -> None:
    one = capture(EVEN, COAST, starts=(0,))
    more = replace(one, phases=(Phase(0, 0), Phase(1, 2000), Phase(7, 3000)))
    assert [(p.start, p.stop, p.kind) for p in lay(more).parts] == [(0, 40, StepKind.COAST)]


def test_a_step_that_lasted_no_sample_is_no_part() -> None:
    line = lay(capture(EVEN, COAST, drive(0.5), drive(0.7), starts=(0, 1000, 1010)))
    assert [(p.start, p.stop, p.level) for p in line.parts] == [(0, 11, 0.0), (11, 40, 0.7)]


def test_a_part_drives_at_no_level_unless_it_is_told() -> None:
    part = Part(3, 9)
    assert (part.level, part.open, part.still, part.discontinuous) == (0.0, False, False, False)
    line = lay(capture(EVEN, COAST, starts=(0,)))
    assert (line.lost, line.coarser, line.past) == (0, 1.0, None)
    stopped = replace(line, parts=(Part(0, 10), Part(10, 15, discontinuous=True), Part(15, 40)))
    assert stopped.stopped.nonzero()[0].tolist() == list(range(10, 15))
