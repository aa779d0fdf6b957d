"""Whatever a host sends, the board answers or ignores it, and the bridge obeys the state."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorid.sim.board import Board
from motorid.sim.options import parse_url
from motorid.wire.codec import encode_command
from motorid.wire.enums import State
from motorid.wire.hashes import config_hash, program_hash
from motorid.wire.spec import REPLY_BIT, load
from tests.sim.client import CONFIG, coast, duty

SIZES = {"u8": 8, "u16": 16, "u32": 32}


@st.composite
def commands(draw: st.DrawFn) -> bytes:
    """A well-formed command: mostly sensible, sometimes with fields out of range."""
    request = draw(st.integers(1, 5))
    name = draw(st.sampled_from(sorted(load().commands)))
    sensible = draw(st.booleans())
    if name == "configure" and sensible:
        return encode_command(name, request, **CONFIG)
    if name == "add_step" and sensible:
        step: dict[str, Any] = {"index": 0, **draw(st.sampled_from([duty(0.5, 40), coast(9)]))}
        return encode_command(name, request, **step)
    if name == "start" and sensible:
        program = [{"index": 0, **duty(0.5, 40)}]
        fields = {"config_hash": config_hash(CONFIG), "program_hash": program_hash(program)}
        return encode_command(name, request, **fields)
    fields: dict[str, Any] = {}
    for field in load().commands[name].fields:
        if field.type == "text16":
            fields[field.name] = draw(st.sampled_from(["", "acs712-20"]))
            continue
        bits = SIZES.get(field.type)
        limits = (0, 2**bits - 1) if bits else (-(2**31), 2**31 - 1)
        fields[field.name] = draw(st.integers(*limits))
    return encode_command(name, request, **fields)


@pytest.mark.slow
@settings(max_examples=60)
@given(st.lists(st.one_of(commands(), st.binary(max_size=70), st.integers(1, 60)), max_size=30))
def test_no_sequence_breaks_the_board(sequence: list[bytes | int]) -> None:
    said: list[bytes] = []
    board = Board(parse_url("sim://?seed=1"), said.append)
    for item in sequence:
        if isinstance(item, int):
            board.advance(item)
            continue
        before = len(said)
        board.receive(item)
        replies = [payload for payload in said[before:] if payload[0] & REPLY_BIT]
        assert len(replies) <= 2  # stop also answers a zero that it cuts short
        assert board.bench.is_open or board.state == State.RUNNING
