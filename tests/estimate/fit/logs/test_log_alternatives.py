"""What else a late or smoothed current of a log may be: which answer is kept, and what it costs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bench.foreign.plant import STEP_S
from motorid.capture.model import CURRENT
from motorid.estimate.fit.joint_fit import solved
from motorid.estimate.fit.logs import log_lags, log_means
from tests.estimate.fit.logs.test_log_fit import PERIOD_S, logged

FREE = ("R", "L", "K", "B", "J", "T0")


def fitted(objective: float, found: int) -> Any:
    """A fit of two records with so many quantities found in each."""
    records = [SimpleNamespace(found=frozenset(range(found)), rivals=()) for _ in range(2)]
    values = np.array([objective])
    return records, SimpleNamespace(objective=objective, fair=objective, values=values)


@pytest.mark.parametrize(("price", "kept"), [(0.0, 90.0), (4.9, 90.0), (5.1, 100.0)])
def test_what_was_found_costs_its_price_in_each_record(price: float, kept: float) -> None:
    """10 of F more for one quantity more in each of two records."""
    records, solution = log_means.likelier(fitted(100.0, 1), fitted(90.0, 2), price)
    assert solution.objective == kept
    (rival,) = records[0].rivals
    assert rival.values == [190.0 - kept]
    assert rival.behind == max(190.0 - 2 * kept, 0.0)


def test_the_same_fit_is_no_rival_of_itself() -> None:
    one = fitted(1.0, 0)
    assert log_means.likelier(one, one, 3.0) is one
    assert one[0][0].rivals == ()


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A fit of a log whose current is neither late nor smoothed."""
    return solved([logged(tmp_path_factory.mktemp("sound"))], {}, ())


@pytest.mark.slow
def test_a_current_that_is_as_stamped_stays_so(sound: Any) -> None:
    captures = [record.capture for record in sound[0]]
    assert log_lags.taken(sound, captures, FREE, {}, {}) is sound
    assert log_means.taken(sound, FREE, {}, {}) is sound


@pytest.mark.slow
def test_a_current_taken_earlier_is_declared_later(sound: Any, tmp_path: Path) -> None:
    def late(current: Any) -> Any:
        steps = 3 * round(PERIOD_S / STEP_S)
        return np.concatenate([np.full(steps, current[0]), current[:-steps]])

    read = logged(tmp_path, i=late)
    (record,), solution = sound
    known = dict(zip(FREE, solution.values.tolist(), strict=True))
    rough = record.twin()
    rough.found, rough.instances = {log_lags.LAG}, (log_lags.LAG,)
    worse = replace(solution, own=(np.array([3.1 * PERIOD_S]),), objective=np.inf)
    (record,), _ = log_lags.taken(([rough], worse), [read], FREE, known, {})
    taken_s = record.capture.provenance[log_lags.TAKEN]
    assert taken_s == pytest.approx(3 * PERIOD_S, rel=1e-6)
    assert record.capture.channels[CURRENT].delay_s == pytest.approx(taken_s)
