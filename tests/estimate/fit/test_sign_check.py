"""A channel of the wrong sign is found, and turned round whatever its sign is made of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motorid.capture.model import CURRENT, POSITION, VOLTAGE, Capture
from motorid.estimate.fit import sign_check
from motorid.estimate.model.capture_model import MotorRecord
from motorid.estimate.results.estimate import PARAMETERS
from tests.exact_capture import FAULHABER, clean_capture

CHANNELS = {"current": CURRENT, "encoder": POSITION, "voltage": VOLTAGE}


def reversed_(name: str) -> Capture:
    """A capture whose readings of a channel are negated, and its scale left alone."""
    good = clean_capture(FAULHABER)
    channel = replace(good.channels[name], raw=-np.asarray(good.channels[name].raw))
    return replace(good, channels={**good.channels, name: channel})


@pytest.mark.parametrize("which", CHANNELS)
def test_a_reversed_channel_is_found_and_put_right(which: str) -> None:
    capture = reversed_(CHANNELS[which])
    with pytest.raises(sign_check.WrongSignError, match=f"sign of the {which}") as caught:
        sign_check.insist([MotorRecord(capture, PARAMETERS, {})])
    (right,) = sign_check.put_right([capture], caught.value)
    for name, channel in clean_capture(FAULHABER).channels.items():
        assert np.array_equal(right.channels[name].values, channel.values)
    said = sign_check.allowed(caught.value)
    assert said.allowed
    assert "other way round" in said.evidence
    assert not caught.value.suspect.allowed


def test_a_good_capture_has_no_wrong_sign() -> None:
    assert sign_check.wrong([MotorRecord(clean_capture(FAULHABER), PARAMETERS, {})]) == ""
