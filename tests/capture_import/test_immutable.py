"""What a reader has found, nobody rewrites: each record by its name."""

from __future__ import annotations

import pytest

from motorid.capture.columns import BadCell, Columns, Described
from motorid.capture.csv_marks import Marks
from motorid.capture.csv_text import Extent
from motorid.capture.declared import Aperture, LowPass, Nonlinearity
from motorid.capture.formats import Format
from motorid.capture.mapping import ChannelMap
from motorid.capture.model import Capture, Channel, Gap, Phase, Stated, Wiring
from motorid.capture.stamp_period import Grid, _Bounds
from motorid.capture.stamps import Clock
from motorid.capture.table_options import TableOptions
from motorid.capture.units import Unit
from tests.estimate.test_immutable_records import writable


@pytest.mark.parametrize(
    "record",
    [
        Aperture, BadCell, Capture, Channel, ChannelMap, Clock, Columns, Described, Extent, Format,
        Gap, Grid, LowPass, Marks, Nonlinearity, Phase, Stated, TableOptions, Unit, Wiring, _Bounds,
    ],
)  # fmt: skip
def test_a_record_is_not_rewritten(record: type) -> None:
    assert not writable(record)
