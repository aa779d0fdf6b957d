"""A board of a newer minor says what this version has no name for; nothing is lost for it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motorid.acquire import record
from motorid.acquire.assemble import Assembler
from motorid.acquire.channels import position
from motorid.capture import store
from motorid.errors import DataError
from motorid.wire.codec import Event, Reply, SampleBlock
from motorid.wire.codec import decode as known
from motorid.wire.enums import ChannelKind
from tests.acquire.rigs import sim_rig

FACT = {
    "scale": 1.0, "pwm_phase_permille": 0, "aperture_ns": 0, "delay_ns": 0, "filter_ns": 0,
    "counts_per_turn": 4096,
}  # fmt: skip
COUNTS = np.arange(4)


@pytest.mark.slow
def test_an_end_reason_without_a_name_is_a_number(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def newer(payload: bytes) -> Any:
        message = known(payload)
        if isinstance(message, Event) and message.name == "done":
            message.fields["reason"] = 67
        return message

    for module in ("board", "assemble"):
        monkeypatch.setattr(f"motorid.acquire.{module}.decode", newer)
    rig = sim_rig()
    path = record.capture(rig, rig.program, tmp_path / "run.h5")
    capture = store.load(path)
    assert capture.end_reason == "67"
    assert len(capture) == 3800


@pytest.mark.slow
def test_a_channel_without_a_name_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def newer(payload: bytes) -> Any:
        message = known(payload)
        if isinstance(message, Reply) and message.name == "describe_channel":
            number = message.fields["channel"]
            message.fields["channel"] = 9 if number == 2 else number  # as if the supply were new
        return message

    for module in ("board", "assemble"):
        monkeypatch.setattr(f"motorid.acquire.{module}.decode", newer)
    rig = sim_rig()
    capture = store.load(record.capture(rig, rig.program, tmp_path / "run.h5"))
    assert capture.end_reason == "completed"
    assert "9" in capture.provenance["descriptors"]


def test_what_a_damaged_frame_says_of_the_end_is_not_believed() -> None:
    """Figures beyond the program make no gap of billions of samples."""
    assembler = Assembler({})
    assembler.marks = {"samples": 3800}
    assembler.done = {"samples": 3800, "dropped": 4_000_000_000, "reason": 0}
    assert assembler._taken() == 3800


def test_a_block_far_beyond_the_run_is_left_out_even_without_the_reply_to_start() -> None:
    import numpy as np

    from motorid.acquire.timeline import Timeline
    from motorid.wire.enums import Channel

    def block(tick: int, sequence: int) -> SampleBlock:
        samples = np.zeros((10, 1), np.int16)
        return SampleBlock(sequence, tick, 0, 0, (Channel.CURRENT,), samples)

    line = Timeline(100, 1000)
    line.add(block(5000, 0))
    line.add(block(5000 + 100 * 1_000_000, 1))
    line.add(block(6000, 2))
    assert (len(line.blocks), line.impossible) == (2, 1)
    assert line.arrays().gaps == ()


def test_known_kinds_are_read() -> None:
    for kind in ChannelKind:
        assert position(COUNTS, FACT | {"kind": int(kind)}, 4096).kind == kind.name.lower()


def test_an_unknown_kind_is_refused_in_a_sentence() -> None:
    with pytest.raises(DataError, match=r"does not know \(206\): update motorid"):
        position(COUNTS, FACT | {"kind": 206}, 4096)
