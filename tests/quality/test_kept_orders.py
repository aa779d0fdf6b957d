"""Orders outlive the station that accepted them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.errors import DataError
from motorid.workflow.kept_orders import FILE, KeptOrders


def test_what_has_no_verdict_is_known_again(tmp_path: Path) -> None:
    first = KeptOrders(tmp_path)
    for serial in ("D1", "D2", "D3"):
        first.accepted(serial)
    first.done("D2")
    first.done("unknown")
    again = KeptOrders(tmp_path)
    assert again.waiting() == first.waiting() == ("D1", "D3")
    again.done("D1")
    again.done("D3")
    assert KeptOrders(tmp_path).waiting() == ()
    assert (tmp_path / FILE).read_bytes() == b""  # nothing piles up


@pytest.mark.slow
@given(cut=st.integers(0, 200), serials=st.lists(st.text(max_size=9), max_size=5, unique=True))
def test_a_torn_line_loses_no_other(
    tmp_path_factory: pytest.TempPathFactory, cut: int, serials: list[str]
) -> None:
    folder = tmp_path_factory.mktemp("shift")
    kept = KeptOrders(folder)
    for serial in serials:
        kept.accepted(serial)
    path = folder / FILE
    whole = path.read_bytes() if path.exists() else b""
    path.write_bytes(whole[:cut])
    lines = whole[:cut].count(b"\n")
    assert KeptOrders(folder).waiting() == tuple(serials[:lines])


def test_damage_is_said_where_it_is(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text('{"accepted": "D1"}\nnonsense\n{"done": "D1"}\n')
    with pytest.raises(DataError, match=r"orders\.jsonl, line 2, is damaged"):
        KeptOrders(tmp_path)


def test_an_order_that_cannot_be_kept_is_not_accepted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And half a line on a full disk does not spoil the next one."""
    kept = KeptOrders(tmp_path)
    kept.accepted("D1")

    def full(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(DataError, match=r"No space left on device.*no order can be accepted"):
        kept.accepted("D2")
    monkeypatch.undo()
    kept.accepted("D3")
    assert kept.waiting() == KeptOrders(tmp_path).waiting() == ("D1", "D3")
