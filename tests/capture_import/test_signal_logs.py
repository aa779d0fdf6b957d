"""Logs of signals without the libraries that read them: names, units, stamps and limits."""

from __future__ import annotations

import struct
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.capture import recording_child
from motorid.capture.recording_child import Signal
from motorid.errors import DataError
from motorid.limits import RECORDING
from tests.capture_import.test_children import log_of, record, start


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits that a test reaches: three signals of four readings, six numbers in all."""
    monkeypatch.setattr(
        recording_child, "RECORDING", replace(RECORDING, columns=3, rows=4, numbers=6)
    )


def libraries(monkeypatch: pytest.MonkeyPatch, **modules: Any) -> None:
    """In place of installed ones, by names with ``__`` for a dot."""
    for name, one in modules.items():
        monkeypatch.setitem(sys.modules, name.replace("__", "."), one)


def found(signals: Any) -> list[tuple[str, Any, str]]:
    return [
        (name, None if values is None else np.asarray(values).tolist(), unit)
        for name, values, unit in signals
    ]


# -- limits
@pytest.mark.parametrize(
    ("sizes", "good"),
    [
        ([2, 2, 2], True), ([4, 2], True), ([1, 1, 1, 1], False), ([5], False), ([3, 3], True),
        ([3, 4], False), ([4, 3], False), ([2, 2, 3], False),
    ],
)  # fmt: skip
def test_a_log_of_so_many_signals_and_readings(
    sizes: list[int], good: bool, few: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    signals = [Signal(f"s{n}", np.ones(size)) for n, size in enumerate(sizes)]
    others = [Signal("none", None), Signal("text", np.array(["a"] * 9))]  # which count for nothing
    monkeypatch.setattr(recording_child, "KINDS", {b"LOG": lambda _: iter([*others, *signals])})
    source, target = tmp_path / "a.log", tmp_path / "out.npz"
    source.write_bytes(b"LOG and more")
    if good:
        recording_child.main(str(source), str(target))
        with np.load(target) as stored:
            assert [stored[f"a{n}"].size for n in range(len(sizes))] == sizes
            assert stored["a0"].dtype == np.float64
            assert stored["objects"].tolist() == [["none", "no numbers"], ["text", "no numbers"]]
    else:
        with pytest.raises(DataError, match="more than 3 signals, 4 readings of one or 6 in all"):
            recording_child.main(str(source), str(target))


# -- WPILib
def test_an_entry_is_a_signal_beside_its_stamps(tmp_path: Path) -> None:
    path = tmp_path / "a.wpilog"
    path.write_bytes(
        log_of(
            record(0, 0, start(1, "x", "double")), record(0, 0, start(2, "m", "string")),
            record(1, 200, struct.pack("<d", 2.5)), record(1, 250, struct.pack("<d", -1.0)),
        )
    )  # fmt: skip
    (stamps, values, other) = found(recording_child._wpilog(str(path)))
    assert (stamps[0], stamps[2]) == ("x.time", "s")
    assert stamps[1] == pytest.approx([200e-6, 250e-6])
    assert (values, other) == (("x.value", [2.5, -1.0], ""), ("m", None, ""))


def test_a_log_of_too_many_numbers_is_refused_as_it_is_read(few: None, tmp_path: Path) -> None:
    path = tmp_path / "a.wpilog"
    value = record(1, 5, struct.pack("<d", 2.5))
    path.write_bytes(log_of(record(0, 0, start(1, "x", "double")), *[value] * 3))
    assert len(found(recording_child._wpilog(str(path)))) == 2  # of three readings and stamps each
    path.write_bytes(path.read_bytes() + value)
    with pytest.raises(DataError, match="more than 6 numbers"):
        list(recording_child._wpilog(str(path)))


# -- TDMS
class Channel:
    """Of a TDMS file; its waveform has steps of half a second."""

    def __init__(self, name: str, values: Any, **properties: Any) -> None:
        self.name, self.values, self.properties = name, np.array(values), properties

    def __getitem__(self, _: slice) -> Any:
        return self.values

    def time_track(self) -> Any:
        return 0.5 * np.arange(len(self.values))


def test_channels_of_a_tdms_file(monkeypatch: pytest.MonkeyPatch) -> None:
    moments = np.array(["2026-01-01T00:00:01", "2026-01-01T00:00:03.5"], "datetime64[ms]")
    groups = [
        SimpleNamespace(
            name="g", channels=lambda: [
                Channel("v", [1.0, 2.0], unit_string="V", NI_UnitDescription="A", wf_increment=0.5),
                Channel("i", [3.0, 4.0], NI_UnitDescription="A", wf_increment=0.0),
                Channel("w", [5.0]),
            ],
        ),
        SimpleNamespace(name="h", channels=lambda: [Channel("t", moments, unit_string="odd")]),
    ]  # fmt: skip
    file = SimpleNamespace(read=lambda path: SimpleNamespace(groups=lambda: groups))
    libraries(monkeypatch, nptdms=SimpleNamespace(TdmsFile=file))
    assert found(recording_child._tdms("a.tdms")) == [
        ("g.v", [1.0, 2.0], "V"), ("g.v.time", [0.0, 0.5], "s"), ("g.i", [3.0, 4.0], "A"),
        ("g.w", [5.0], ""), ("h.t", [0.0, 2.5], "s"),
    ]  # fmt: skip


# -- MDF
class Mdf:
    """Two groups: of the first the second channel is its time, the other has none."""

    def __init__(self, _: str) -> None:
        self.groups = [SimpleNamespace(channels="atb"), SimpleNamespace(channels="c")]
        self.masters_db = {0: 1}

    def __enter__(self) -> Mdf:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def get(self, group: int, index: int) -> Any:
        return SimpleNamespace(
            name=self.groups[group].channels[index], samples=np.array([group, index]),
            timestamps=np.array([10.0 * group, 1.0]), unit="V" if not index else None,
        )  # fmt: skip


def test_groups_of_an_mdf_file_have_one_time_each(monkeypatch: pytest.MonkeyPatch) -> None:
    libraries(monkeypatch, asammdf=SimpleNamespace(MDF=Mdf))
    assert found(recording_child._mdf("a.mf4")) == [
        ("group1.time", [0.0, 1.0], "s"), ("group1.a", [0, 0], "V"), ("group1.b", [0, 2], ""),
        ("group2.time", [10.0, 1.0], "s"), ("group2.c", [1, 0], "V"),
    ]  # fmt: skip


# -- MCAP
def mcap(
    monkeypatch: pytest.MonkeyPatch, path: Path, messages: list[tuple[str, int, str, bytes]]
) -> Any:
    """Signals of messages: topic, stamp in ns, encoding and data; ``ros`` alone is decoded."""
    parts = [
        ("schema", SimpleNamespace(topic=topic, message_encoding=encoding),
         SimpleNamespace(log_time=stamp, data=data))
        for topic, stamp, encoding, data in messages
    ]  # fmt: skip
    reader = SimpleNamespace(iter_messages=lambda: iter(parts))

    def decoder_for(encoding: str, schema: str) -> Any:
        return (lambda data: {schema: len(data)}) if encoding == "ros" else None

    ros = SimpleNamespace(decoder_for=decoder_for)
    libraries(
        monkeypatch, mcap=SimpleNamespace(), mcap_ros2=SimpleNamespace(),
        mcap__reader=SimpleNamespace(make_reader=lambda _: reader),
        mcap_ros2__decoder=SimpleNamespace(DecoderFactory=lambda: ros),
    )  # fmt: skip
    path.write_bytes(b"")
    return found(recording_child._mcap(str(path)))


def test_topics_have_their_stamps_since_the_first_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = 1_700_000_000_000_000_000
    signals = mcap(
        monkeypatch, tmp_path / "a",
        [
            ("a", first, "json", b'{"v": 1, "i": 2.5}'), ("odd", first + 1, "odd", b"x"),
            ("b", first + 2_000_000_000, "ros", b"123"), ("text", first, "json", b'"x"'),
            ("a", first + 500_000_000, "json", b'{"v": 3, "i": 4.5}'), ("odd", first, "odd", b"x"),
        ],
    )  # fmt: skip
    assert signals == [
        ("a.time", [0.0, 0.5], "s"), ("a.v", [1.0, 3.0], ""), ("a.i", [2.5, 4.5], ""),
        ("b.time", [2.0], "s"), ("b.schema", [3.0], ""),
        ("odd (no JSON or ROS 2 message)", None, ""), ("text (no JSON or ROS 2 message)", None, ""),
    ]  # fmt: skip


def test_a_message_that_is_no_json_is_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(DataError, match="a message is no JSON: is it damaged"):
        mcap(monkeypatch, tmp_path / "a", [("a", 0, "json", b"{")])


@pytest.mark.parametrize(
    ("text", "messages", "good"),
    [
        (b'{"v": 1, "i": 2}', 2, True),  # three signals, six numbers
        (b'{"v": 1, "i": 2}', 3, False),
        (b'{"v": 1}', 3, True),
        (b'{"v": 1}', 4, False),
        (b'{"v": 1, "i": 2, "w": 3}', 1, False),  # four signals with the stamps
    ],
)
def test_messages_are_counted_with_their_stamps(
    text: bytes, messages: int, good: bool, few: None, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    said = [("a", n, "json", text) for n in range(messages)]
    if good:
        assert len(mcap(monkeypatch, tmp_path / "a", said)[0][1]) == messages
    else:
        with pytest.raises(DataError, match="more than 3 signals"):
            mcap(monkeypatch, tmp_path / "a", said)


def test_lists_and_objects_deeper_than_six_are_left_out() -> None:
    deep: Any = 5
    for _ in range(6):
        deep = [deep]
    members = recording_child._members
    assert dict(members(deep, "t", 0)) == {"t" + "[1]" * 6: 5.0}
    assert dict(members([deep], "t", 0)) == {}
    assert dict(members({"a": (1, np.array([2.0, 3.0]))}, "t", 0)) == {
        "t.a[1]": 1.0, "t.a[2][1]": 2.0, "t.a[2][2]": 3.0,
    }  # fmt: skip
