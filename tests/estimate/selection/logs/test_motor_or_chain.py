"""Brushes that lags and low-passes would explain too, and a current that is late."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from motorid.capture.model import Capture
from motorid.estimate.effects.influence_quantity import Instance
from motorid.estimate.effects.registry import UNSTATED
from motorid.estimate.effects.unstated.current_lag import CURRENT_LAG
from motorid.estimate.effects.unstated.current_smoothing import CURRENT_SMOOTHING
from motorid.estimate.fit.logs.log_unknowns import Fit, of_sizes
from motorid.estimate.fit.multistart import settled
from motorid.estimate.fit.parameter_bounds import merged
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.selection.logs.motor_or_chain import likelier
from tests.estimate.logs_with_effects import PERIOD_S, TRUTH, VOLTS, logged

BRUSHES = (("brush", 0.1 * VOLTS), ("brush_current", 0.02 * VOLTS / TRUTH["R"]))


def _with_lags(captures: Sequence[Capture]) -> Fit:
    """As the fit of a log ends that found a low-pass and a lag of the current, of any size."""
    records = [MotorRecord(capture, PARAMETERS, {}) for capture in captures]
    stamped = settled(records, PARAMETERS, TRUTH)
    for record in records:
        record.as_stamped = merged(TRUTH, stamped)
        record.estimate(*(Instance(quantity) for quantity in UNSTATED))
        sizes = dict.fromkeys((Instance(CURRENT_LAG), Instance(CURRENT_SMOOTHING)), PERIOD_S)
        record.find(of_sizes(record, sizes))
    return records, settled(records, PARAMETERS, TRUTH)


@pytest.mark.slow
def test_brushes_are_no_lags() -> None:
    captures = [logged(*BRUSHES)]
    found = _with_lags(captures)
    records, solution = likelier(captures, found, {})
    assert not records[0].found
    assert solution.objective < found[1].objective  # in the noise that it shows


@pytest.mark.slow
def test_a_late_current_stays_late() -> None:
    captures = [logged(late_rows=3)]
    found = _with_lags(captures)
    assert likelier(captures, found, {}) is found


def test_nothing_is_tried_where_no_lag_was_found() -> None:
    record = MotorRecord(logged(), PARAMETERS, {})
    solution = object()
    fit = [record], solution
    assert likelier([record.capture], fit, {}) is fit  # type: ignore[arg-type]
