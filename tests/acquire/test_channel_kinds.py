"""A channel that a newer board reads in its own way."""

from __future__ import annotations

import numpy as np
import pytest

from motorid.acquire.channels import position
from motorid.errors import DataError
from motorid.wire.enums import ChannelKind

FACT = {
    "scale": 1.0, "pwm_phase_permille": 0, "aperture_ns": 0, "delay_ns": 0, "counts_per_turn": 4096,
}  # fmt: skip
COUNTS = np.arange(4)


def test_known_kinds_are_read() -> None:
    for kind in ChannelKind:
        assert position(COUNTS, FACT | {"kind": int(kind)}, 4096).kind == kind.name.lower()


def test_an_unknown_kind_is_refused_in_a_sentence() -> None:
    with pytest.raises(DataError, match=r"does not know \(206\): update motorid"):
        position(COUNTS, FACT | {"kind": 206}, 4096)
