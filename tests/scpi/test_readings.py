"""From an instrument's answers to traces, rows and a capture, by instruments of a few lines."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motorid.acquire.scpi import build
from motorid.acquire.scpi.bench_file import Source
from motorid.acquire.scpi.dialect import Dialect
from motorid.acquire.scpi.link import Instrument
from motorid.acquire.scpi.notes import Told
from motorid.acquire.scpi.poll import Poller
from motorid.acquire.scpi.recorder import Recorder, Recording, Trace
from motorid.acquire.scpi.scan import scans_of
from motorid.acquire.scpi.supply import Supply
from motorid.capture.model import Gap
from motorid.errors import DataError, LinkError
from motorid.rig import Rig
from tests.acquire.rigs import sim_rig
from tests.scpi.bench import SettableClock

RIG = sim_rig()
TOLD = Told(
    "completed", "now", "7", "a note", {"supply": "S"}, {"over_voltage": 9.0}, (), (), 1.0, ""
)


class Answers:
    """A link that answers by a table, and keeps what it was told. A list is answered in turn."""

    def __init__(self, **answers: Any) -> None:
        self.answers, self.heard = answers, list[str]()

    def write(self, text: str) -> None:
        self.heard.append(text)

    def ask(self, text: str) -> str:
        self.heard.append(text)
        found = self.answers[text]
        return str(found.pop(0) if isinstance(found, list) else found)

    def block(self, text: str, kind: str, big_endian: bool) -> NDArray[Any]:
        self.heard.append(f"{text} {kind} {big_endian}")
        return np.array(self.answers[text], np.uint16)

    def close(self) -> None:
        self.heard.append("closed")


def dialect(kind: str = "recorder", **tables: dict[str, Any]) -> Dialect:
    return Dialect(kind, "mine", "", ("HELLO {channel}",) if kind == "supply" else (), tables)


# -- a scope
WAVEFORM = {"preamble": "P{source}", "data": "D{source}", "type": "H"}


def preamble(
    step_s: float = 0.25, scale: float = 0.5, origin: float = 3.0, reference: float = 8.0
) -> str:
    return f"0,0,3,1,{step_s},0,0,{scale},{origin},{reference}"


def scope(
    answers: dict[str, Any], sources: tuple[Source, ...], **waveform: Any
) -> tuple[Recorder, Answers]:
    link = Answers(**answers)
    made = Instrument("scope", link, "")
    return Recorder(made, dialect(waveform=WAVEFORM | waveform), sources, 3e-5), link


CURRENT = Source("current", ("1",), scale=2.0, zero=0.75)


@pytest.mark.parametrize(("origin", "offset"), [("volts", 8.0 - 3.0 / 0.5), ("counts", 3.0 + 8.0)])
def test_a_waveform_in_units(origin: str, offset: float) -> None:
    answers = {"P1": preamble(), "D1": [10, 12, 20]}
    recorder, link = scope(answers, (CURRENT,), origin=origin, select=["S{source}"], raw_max=20)
    found = recorder.recording()
    assert link.heard == ["S1", "P1", "D1 H False"]
    (trace,) = found.traces
    volts = 0.5 * (np.array([10.0, 12.0, 20.0]) - offset)
    assert trace.scale * (trace.raw - trace.offset) == pytest.approx(2.0 * (volts - 0.75))
    assert trace.resolution == pytest.approx(1.0)
    assert (trace.raw_min, trace.raw_max, trace.late) == (-math.inf, 20, None)
    assert found.time_s.tolist() == [0.0, 0.25, 0.5]
    assert (found.clock_uncertainty, found.uniform, found.polled) == (3e-5, True, False)


def test_a_block_of_no_text_is_no_reading() -> None:
    recorder, _ = scope({"P1": preamble(), "D1": "#0"}, (CURRENT,), type="ascii")
    with pytest.raises(LinkError, match="nothing on input 1"):
        recorder.recording()


@pytest.mark.parametrize("answer", ["1.5,2.5,,3", "#15xxxxx"])
def test_a_waveform_as_text(answer: str) -> None:
    block = "#2111.5,2.5,,3 " if answer[0] == "#" else answer
    recorder, _ = scope({"P1": preamble(), "D1": block}, (CURRENT,), type="ascii")
    (trace,) = recorder.recording().traces
    assert trace.raw.tolist() == [1.5, 2.5, 3.0]
    assert trace.resolution == 0.0  # of no counts


@pytest.mark.parametrize(
    ("answers", "says"),
    [
        ({"P1": "0,0,3,1,0.25,0,0,0.5,3"}, "with 9 numbers, and 10 are its preamble"),
        ({"P1": preamble(scale=0.0)}, "nothing on input 1: is it switched on"),
        ({"P1": preamble(step_s=9.91e37)}, "nothing on input 1"),
        ({"P1": preamble(step_s=0.0)}, "differ in their time base"),
        ({"D1": []}, "with no reading"),
        ({"P2": preamble(step_s=0.5)}, "differ in their time base"),
        ({"D2": [1, 2]}, "differ in their time base"),
    ],
)
def test_a_waveform_that_is_none(answers: dict[str, Any], says: str) -> None:
    right = {"P1": preamble(), "P2": preamble(), "D1": [1, 2, 3], "D2": [1, 2, 3]}
    both = (CURRENT, Source("terminal_voltage", ("2",)))
    recorder, _ = scope(right | answers, both)
    with pytest.raises(LinkError, match=says):
        recorder.recording()


def test_an_encoder_s_lines_count_and_lost_edges_leave_it_out() -> None:
    encoder = Source("position", ("1", "2"), scale=-1.0)
    answers = {"P1": preamble(), "P2": preamble(), "D1": [0, 9, 9, 0], "D2": [0, 0, 9, 9]}
    found = scope(answers, (encoder,))[0].recording()
    assert found.traces[0].raw.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert (found.traces[0].scale, found.traces[0].resolution) == (-1.0, 1.0)
    found = scope(answers | {"D2": [0, 9, 9, 9]}, (CURRENT, encoder))[0].recording()
    assert [one.source.name for one in found.traces] == ["current"]
    (note,) = found.notes
    assert note.startswith("position is left out: both lines of the encoder change at once")


def test_a_recording_s_start_in_the_instrument_s_words() -> None:
    link = Answers()
    start = ["{rate_hz} {period_s} {duration_s} {points} {inputs} {readings} {sources}"]
    both = (CURRENT, Source("position", ("2", "3")))
    Recorder(Instrument("scope", link, ""), dialect(acquire={"start": start}), both, 0.0).start(
        80.0, 1.255
    )
    assert link.heard == ["80.0 0.0125 1.255 101 3 303 1,2,3"]


@pytest.mark.parametrize(
    ("facts", "answers"),
    [
        ({"mask": 8, "value": 0}, [9, 8, 7]),
        ({"mask": 3, "value": 2}, [0, 4, 6]),
        ({"value": 5}, [4, 7, 5]),
        ({}, [1, 2, 0]),
    ],
)
def test_a_recorder_is_done_by_its_word(facts: dict[str, int], answers: list[int]) -> None:
    clock, link = SettableClock(), Answers(DONE=list(answers))
    told = dialect(acquire={"done": "DONE", **facts})
    Recorder(Instrument("scope", link, ""), told, (), 0.0).wait(clock, 9.0)
    assert link.answers["DONE"] == []
    assert clock.now() == pytest.approx(2 * 0.02)
    late = Answers(DONE=answers[0])
    with pytest.raises(LinkError, match=rf"answers 'DONE' with {answers[0]}\): is it triggered"):
        Recorder(Instrument("scope", late, ""), told, (), 0.0).wait(clock, 0.05)
    assert clock.now() == pytest.approx(0.04 + 0.06)


def test_a_recorder_without_a_word_is_waited_for() -> None:
    clock, link = SettableClock(), Answers()
    one = Recorder(Instrument("scope", link, ""), dialect(acquire={"stop": ["A", "B"]}), (), 0.0)
    one.wait(clock, 5.0)
    assert clock.now() == pytest.approx(2.5)
    one.stop()
    assert link.heard == ["A", "B"]
    Recorder(Instrument("scope", link, ""), dialect(), (), 0.0).stop()
    assert len(link.heard) == 2


# -- a scanning DAQ
def test_a_scan_s_stamp_is_its_last_reading_s() -> None:
    rows = [
        (10.0 * n + k, 2.0 * n + late, channel)
        for n in range(3)
        for k, (late, channel) in enumerate([(0.0, 101), (0.3, 102), (0.5, 103)])
    ]
    found = scans_of(np.array(rows).ravel(), ("reading", "time", "channel"), ("103", "101", "102"))
    assert found.readings["102"].tolist() == [1.0, 11.0, 21.0]
    assert found.time_s.tolist() == [0.0, 2.0, 4.0]
    assert found.late_s == pytest.approx({"103": 0.0, "101": 0.5, "102": 0.2})
    # inputs .25 s apart on the whole, stamps .2 s at the least
    assert found.late_uncertainty_s == pytest.approx(math.hypot(0.25, 0.2) / math.sqrt(12))
    assert (found.is_uniform, found.period_uncertainty) == (False, 0.0)  # of so few scans
    assert "a scan of 2 s reads its inputs one after another, the first 0.5 s before" in found.note


@pytest.mark.parametrize("late", [0.0, 0.4])
def test_even_scans_lie_on_a_grid(late: float) -> None:
    stamps = np.arange(20.0) + np.where(np.arange(20) == 7, late, 0.0)
    rows = np.column_stack([np.ones(20), stamps, np.full(20, 101.0)])
    found = scans_of(rows.ravel(), ("reading", "time", "channel"), ("101",))
    assert found.is_uniform is (late == 0.0)
    assert found.time_s == pytest.approx(stamps)
    assert found.late_s == {"101": 0.0}
    assert (found.period_uncertainty > 0.0) is (late == 0.0)
    one = scans_of(rows[:1].ravel(), ("reading", "time", "channel"), ("101",))
    assert (one.time_s.tolist(), one.late_uncertainty_s) == ([0.0], 0.0)


# -- one query after another
def test_rows_of_queries_and_how_late_each_is() -> None:
    clock = SettableClock()

    class Slow(Answers):
        def ask(self, text: str) -> str:
            clock.sleep(0.1)
            return super().ask(text)

    answers = {"V1?": [3, 4], "BOTH?": ["1,2.5", "1,9.91e37"]}
    told = dialect("supply", measure={"terminal_voltage": "V{channel}?"})
    supply = Supply(Instrument("supply", Slow(**answers), ""), told)
    meter = Instrument("tacho", Slow(**{"W?": [30, 50]}), "")
    sources = (
        Source("terminal_voltage"),
        Source("current", query="BOTH?", place=1, scale=-2.0, zero=0.5),
        Source("speed", instrument="tacho", query="W?"),
    )
    poller = Poller(supply, {"tacho": meter}, sources, clock)
    assert poller.latest() == (None, None)
    assert len(poller.recording().time_s) == 0
    poller.row()
    assert poller.latest() == (-4.0, 30.0)
    clock.sleep(0.7)
    poller.row()
    assert poller.latest() == (None, 50.0)  # the current was none
    found = poller.recording()
    assert found.time_s == pytest.approx([0.0, 1.0])
    assert (found.uniform, found.polled, found.clock_uncertainty) == (False, True, 1e-4)
    volts, current, speed = found.traces
    assert (volts.raw.tolist(), speed.raw.tolist()) == ([3.0, 4.0], [30.0, 50.0])
    assert (current.scale, current.offset, current.raw[0]) == (-2.0, 0.5, 2.5)
    doubt = 1.0 / math.sqrt(12)
    assert volts.late == pytest.approx((0.1, doubt))  # a row's stamp is its middle
    assert current.late == pytest.approx((0.0, doubt))
    assert speed.late == pytest.approx((-0.1, doubt))


def test_an_answer_with_too_few_numbers_is_said() -> None:
    supply = Supply(Instrument("supply", Answers(**{"B?": "1,2"}), ""), dialect("supply"))
    poller = Poller(supply, {}, (Source("current", query="B?", place=2),), SettableClock())
    with pytest.raises(
        LinkError, match=r"answers 'B\?' with 2 numbers, and channels.current.field is 2"
    ):
        poller.row()
    assert poller.rows == []


# -- a capture
def recording(**facts: Any) -> Recording:
    raw = np.array([0.0, 10.0, 20.0, 15.0])
    current = Trace(
        Source("current", facts=facts.pop("facts", {})),
        raw,
        0.5,
        2.0,
        0.5,
        0.0,
        20.0,
        facts.pop("late", None),
    )
    volts = replace(current, source=Source("terminal_voltage", sense="terminals"), late=None)
    given = {"uniform": True, "notes": ("a word",)} | facts
    return Recording(given.pop("time_s", 0.25 * np.arange(4)), (current, volts), 3e-5, **given)


def test_a_recording_becomes_a_capture() -> None:
    found = build.capture_of(RIG, recording(), TOLD)
    assert found.time_s == pytest.approx([0.0, 0.25, 0.5, 0.75])
    assert (found.clock_hz, found.clock_uncertainty) == (pytest.approx(4.0), 3e-5)
    current, volts = found.channels["current"], found.channels["terminal_voltage"]
    assert current.values.tolist() == [-1.0, 4.0, 9.0, 6.5]
    assert (current.unit, current.resolution, current.sense, volts.sense) == (
        "A",
        0.5,
        None,
        "terminals",
    )
    assert current.saturated.tolist() == [True, False, True, False]
    assert "delay" in current.undeclared
    assert (found.end_reason, found.ambient_c, found.wiring) == ("completed", 23.0, RIG.wiring)
    known = found.provenance
    assert known["notes"][0] == "a word"
    assert (known["serial"], known["note"], known["created"]) == ("7", "a note", "now")
    assert known["instruments"]["protection"] == {"over_voltage": 9.0}


def test_when_a_channel_was_read_adds_to_its_delay() -> None:
    late = build.capture_of(RIG, recording(late=(0.02, 3e-3)), TOLD).channels["current"]
    assert (late.delay_s, late.delay_uncertainty_s) == (pytest.approx(0.02), pytest.approx(3e-3))
    assert "delay" not in late.undeclared
    facts = {"delay": "5ms", "delay_uncertainty": "4ms"}
    stated = build.capture_of(RIG, recording(facts=facts), TOLD).channels["current"]
    assert (stated.delay_s, stated.delay_uncertainty_s) == (
        pytest.approx(5e-3), pytest.approx(4e-3)
    )  # fmt: skip
    both = build.capture_of(RIG, recording(late=(0.02, 3e-3), facts=facts), TOLD).channels[
        "current"
    ]
    assert both.delay_s == pytest.approx(0.025)
    assert both.delay_uncertainty_s == pytest.approx(5e-3)


def test_stamps_that_repeat_are_left_out_and_pauses_are_gaps() -> None:
    stamps = np.array([0.0, 0.25, 0.25, 0.5])
    found = build.capture_of(RIG, recording(uniform=False, time_s=stamps), TOLD)
    assert found.time_s == pytest.approx([0.0, 0.25, 0.5])
    assert found.channels["current"].raw.tolist() == [0.0, 10.0, 15.0]
    pause = np.array([0.0, 0.25, 0.5, 1.5])
    found = build.capture_of(RIG, recording(uniform=False, time_s=pause), TOLD)
    assert found.gaps == (Gap(3, 3, "the time column pauses"),)


@pytest.mark.parametrize("stamps", [np.zeros(4), np.array([0.0, 0.0, -1.0, -1.0])])
def test_a_recording_of_one_moment_is_none(stamps: NDArray[np.float64]) -> None:
    with pytest.raises(DataError, match="not two readings of the run arrived"):
        build.capture_of(RIG, recording(uniform=False, time_s=stamps), TOLD)


@pytest.mark.parametrize(
    ("reverse", "scale", "sign"), [(False, 5.0, 1), (True, 5.0, -1), (True, -5.0, 1)]
)
def test_an_encoder_s_counts_are_of_the_rig(reverse: bool, scale: float, sign: int) -> None:
    trace = Trace(Source("position"), np.array([0.0, 1.0, 2.0, 3.0]), scale, 0.0, 1.0)
    rig: Rig = replace(RIG, encoder_reversed=reverse)
    made = recording()
    found = build.capture_of(rig, replace(made, traces=(*made.traces, trace)), TOLD)
    count = 2 * math.pi / RIG.wiring.counts_per_turn
    position = found.channels["position"]
    assert position.values == pytest.approx(sign * count * np.arange(4))
    assert position.resolution == pytest.approx(count)
    assert "gain" not in position.undeclared
