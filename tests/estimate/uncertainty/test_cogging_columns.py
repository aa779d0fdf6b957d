"""What cogging does to a log's readings by straight lines, against the response that has it."""

from __future__ import annotations

import numpy as np

from motorid.estimate.effects.rotor.cogging import COGGING
from motorid.estimate.effects.rotor.repeating import of_order
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.model.repeating_response import RepeatingResponse
from motorid.estimate.results.estimate import PARAMETERS
from motorid.estimate.uncertainty.cogging_columns import cogging_columns
from tests.estimate.logs_with_effects import TRUTH, logged

ORDER = 12


def test_a_log_shows_what_the_response_shows() -> None:
    record = MotorRecord(logged(), PARAMETERS, {})
    shared, own = np.array(list(TRUTH.values())), np.zeros(len(record.unknowns))
    record.retake_sources(shared, own)
    slopes = RepeatingResponse(record, shared, own).slopes(ORDER)
    (told,) = cogging_columns(record, shared, own, [ORDER])
    for one, sign, row in zip(of_order(COGGING, ORDER), (1.0, -1.0), told, strict=True):
        shown = np.concatenate([slopes[one][m.block.name] for m in record.measured])
        assert np.linalg.norm(sign * row - shown) < 0.05 * np.linalg.norm(shown)
