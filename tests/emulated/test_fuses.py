"""The brown-out detector's fuse, as the emulated boards read and tell it; and their link."""

from __future__ import annotations

from typing import Any

import pytest

from motorid.acquire.link_test import measure_link
from tests.conformance.boards import emulator_lacks, opened
from tests.conformance.client import Client

pytestmark = pytest.mark.slow
# the lowest three bits of the extended fuse; the others read 1 on an ATmega328P
LEVELS_MV = {0xFC: 4300, 0xFD: 2700, 0xFE: 1800, 0xFF: 0}
LEAST_MV = {"uno": 3780, "mega": 4500}  # at 16 MHz, by the data sheets


@pytest.mark.parametrize("name", ["uno", "mega"])
def test_the_fuse_is_read_and_told(name: str) -> None:
    if lack := emulator_lacks():
        pytest.skip(f"no emulated {name}: {lack}")
    with opened(name) as board:
        emulator: Any = board.port.board  # type: ignore[attr-defined]
        client = Client(board.port)
        client.bring_up()
        assert client.identity["brown_out_mv"] == LEVELS_MV[0xFD]  # as boards are sold
        assert client.identity["brown_out_least_mv"] == LEAST_MV[name]
        found = measure_link(board.port, 64)  # at the line's full rate
        assert found.clean, found
        for fuse, level_mv in LEVELS_MV.items():
            emulator.set("efuse", fuse)
            for _ in range(4):  # whatever interrupt comes meanwhile
                identity = client.get("identify", host_major=1, host_minor=3)
                assert identity["brown_out_mv"] == level_mv
