"""A run of instruments from opening to closing: who is asked what, and what is kept and raised."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire.scpi import run as room
from motorid.acquire.scpi.bench_file import of_rig
from motorid.acquire.scpi.notes import Told
from motorid.acquire.scpi.run import _Bench, _Run, capture_all, refuse
from motorid.capture import store
from motorid.errors import DataError, LinkError, RigError, UsageError
from motorid.program import Decay, Program, Step, StepKind
from motorid.rig import Calibration, Rig
from tests.scpi.bench import Bench, SettableClock
from tests.scpi.rigs import MockLink, rig

UP = Step(StepKind.DRIVE_VOLTS, 0.04, 3.0, Decay.SYNCHRONOUS_SLOW)
SHORT = Program((Step(StepKind.COAST, 0.02), UP, Step(StepKind.COAST, 0.02)))
METER = """
[channels.current]
[channels.terminal_voltage]
[channels.speed]
instrument = "tacho"
query = "READ?"
[meters.tacho]
resource = "tacho at"
error = ""
timeout_s = 2.5
"""


class Still(Bench):
    """The mock bench with a resistor of 5 ohm in the motor's place: nothing is integrated."""

    def catch_up(self) -> None:
        volts = self.settings["VOLT"] if self.on else 0.0
        self.motor.volts, self.motor.current = volts, volts / 5.0
        while len(self.rows) < self.points and self.next_s <= self.now():
            self.rows.append((volts / 5.0, volts, 0.0))
            self.next_s += self.period_s


class Opened:
    """Opens links to a still bench, and notes what was opened, heard and closed."""

    def __init__(self, **options: Any) -> None:
        self.clock = SettableClock()
        self.bench = Still(self.clock.now, self.clock.sleep, **options)
        self.opened, self.links = list[Any](), list[MockLink]()
        self.heard: list[str] = []

    def __call__(self, backend: str, resource: str, timeout_s: float, name: str) -> MockLink:
        self.opened.append((backend, resource, timeout_s, name))
        answers: dict[str, Callable[[str], Any]] = {
            "supply": self.bench.supply, "scope": self.bench.scope, "tacho": self.tacho,
        }  # fmt: skip

        def answer(text: str) -> Any:
            self.heard.append(f"{name} {text}")
            return answers["scope" if name == "recorder" else name](text)

        self.links.append(MockLink(answer))
        return self.links[-1]

    def tacho(self, text: str) -> str:
        return {"*IDN?": "MOCK,TACHO,3,1.0", "READ?": "0.5"}.get(text, "")

    def of(self, *texts: str) -> list[str]:
        return [text for text in self.heard if text in texts]

    def run(self, one: Rig, *paths: Path, program: Program = SHORT, **more: Any) -> list[Path]:
        return capture_all(one, program, paths, open_link=self, clock=self.clock, **more)


def polled(folder: Path, more: str = "") -> Rig:
    return rig(folder, scope=False, rate_hz=100, more=more)


@pytest.mark.slow
def test_instruments_are_opened_asked_and_closed(tmp_path: Path) -> None:
    opened, said = Opened(), list[str]()
    paths = [tmp_path / "a.h5", tmp_path / "b.h5"]
    assert opened.run(polled(tmp_path, METER), *paths, say=said.append, serial="S", note="N") == (
        paths
    )
    (warning,) = said
    assert warning.startswith("no board guards this run")
    assert opened.opened == [
        ("@py", "supply", 5.0, "supply"), ("@py", "tacho at", 2.5, "tacho"),
    ]  # fmt: skip
    assert all(link.closed for link in opened.links)
    assert opened.heard.index("tacho *IDN?") < opened.heard.index("supply OUTP ON")
    assert "tacho SYST:ERR?" not in opened.heard
    assert opened.bench.settings["VOLT:PROT"] == 9.0  # limits.supply_max_v
    assert opened.bench.settings["CURR"] == 4.0
    run = store.load(paths[1])
    kept = run.provenance
    assert (run.end_reason, kept["serial"], kept["note"]) == ("completed", "S", "N")
    assert kept["created"].startswith("20")
    found = kept["instruments"]
    assert found["identities"] == {"supply": "MOCK,SUPPLY,1,1.0", "tacho": "MOCK,TACHO,3,1.0"}
    assert found["protection"]["current_limit"] == 4.0
    assert [one["kind"] for one in found["commanded"]] == ["coast", "drive_volts", "coast"]
    assert found["file"] == (tmp_path / "instruments.toml").read_text()
    assert run.channels["speed"].values.tolist() == [0.5] * len(run)
    assert max(run.channels["current"].values) == pytest.approx(0.6)
    assert not opened.bench.on


def test_a_limit_of_voltage_protects_where_there_is_one(tmp_path: Path) -> None:
    opened, one = Opened(), polled(tmp_path)
    one = replace(one, limits=replace(one.limits, voltage_v=7.0))
    opened.run(one, tmp_path / "a.h5")
    assert opened.bench.settings["VOLT:PROT"] == 7.0


def test_a_recorder_records_as_long_as_the_run_may_take(tmp_path: Path) -> None:
    opened = Opened(reply_s=1e-3)
    path = tmp_path / "a.h5"
    opened.run(rig(tmp_path), path)
    # 80 ms, eight round trips of 1 ms for each of three steps, 20 ms before it, 200 ms to spare
    assert opened.bench.points == pytest.approx(5000 * 0.324, abs=1)
    assert [one[3] for one in opened.opened] == ["supply", "recorder"]
    assert all(link.closed for link in opened.links)
    begins = opened.heard.index(f"recorder :ACQ:POIN {opened.bench.points}")
    assert begins < opened.heard.index("supply VOLT 3.0")
    last_off = max(n for n, text in enumerate(opened.heard) if text == "supply OUTP OFF")
    asks = opened.heard.index("recorder :OPER:COND?")
    offs = [n for n, text in enumerate(opened.heard) if text == "supply OUTP OFF"]
    assert any(begins < n < asks for n in offs)
    assert last_off > asks  # and once more, whatever came
    found = store.load(path)
    assert found.provenance["instruments"]["identities"]["recorder"] == "MOCK,SCOPE,2,1.0"
    rises = found.time_s[found.channels["terminal_voltage"].values > 1.5]
    assert rises[0] == pytest.approx(0.04, abs=0.01)  # after the lead and the first coast
    assert rises[-1] - rises[0] == pytest.approx(0.04, abs=0.01)
    assert ":STOP" not in "".join(opened.heard)


def test_a_recorder_that_is_never_done_is_waited_for_and_stopped(tmp_path: Path) -> None:
    opened = Opened(reply_s=1e-3)
    opened.bench.scope = _never_done(opened.bench)  # type: ignore[method-assign]
    with pytest.raises(LinkError, match=r"has not finished .*; \d+ samples are kept in"):
        opened.run(rig(tmp_path), tmp_path / "a.h5")
    assert opened.clock.now() == pytest.approx(10.0 + 0.324 + 0.1, abs=0.2)
    assert opened.of("recorder :STOP") == ["recorder :STOP"]
    assert store.load(tmp_path / "a.h5").end_reason == "link lost"


def _never_done(bench: Bench) -> Any:
    known = bench.scope
    return lambda text: "8" if text == ":OPER:COND?" else known(text)


def test_a_link_that_is_lost_is_opened_again_to_switch_off(tmp_path: Path) -> None:
    opened = Opened(silent_after="STAT:QUES?")
    known = opened.__call__

    def open_link(*words: Any) -> MockLink:
        opened.bench.dead = opened.bench.dead and len(opened.opened) == 0
        opened.bench.silent_after = "" if opened.opened else opened.bench.silent_after
        return known(*words)

    with pytest.raises(LinkError, match=r"no answer to 'STAT:QUES\?'") as e:
        capture_all(
            polled(tmp_path), SHORT, [tmp_path / "a.h5"], open_link=open_link, clock=opened.clock
        )
    assert "MAY STILL BE ON" not in str(e.value)
    assert opened.opened == 2 * [("@py", "supply", 5.0, "supply")]
    assert [link.closed for link in opened.links] == [True, True]
    assert not opened.bench.on


def test_what_opens_in_part_is_closed(tmp_path: Path) -> None:
    opened = Opened()
    opened.tacho = lambda text: ""  # type: ignore[method-assign]
    with pytest.raises(LinkError, match=r"answers \*IDN\? with nothing"):
        opened.run(polled(tmp_path, METER), tmp_path / "a.h5")
    assert [link.closed for link in opened.links] == [True, True]
    assert not opened.of("supply OUTP ON")


# -- what cannot be run
def test_what_instruments_cannot_do_is_refused(tmp_path: Path) -> None:
    one = polled(tmp_path)
    known = {"current": Calibration(gain=1.1)}
    with pytest.raises(RigError, match=r"\[calibration\] is of a board"):
        refuse(replace(one, calibration=known), of_rig(one), SHORT)
    refuse(one, of_rig(one), SHORT)


@pytest.mark.parametrize(
    ("kind", "volts", "quadrants"),
    [(StepKind.BRAKE, 0.0, 2), (StepKind.DRIVE_VOLTS, -3.0, 4), (StepKind.DRIVE_VOLTS, 3.0, 1)],
)
def test_what_an_output_does_is_by_its_quadrants(
    kind: StepKind, volts: float, quadrants: int, tmp_path: Path
) -> None:
    one = polled(tmp_path)
    decay = Decay.SYNCHRONOUS_SLOW if volts else Decay(0)
    program = Program((UP, Step(kind, 0.1, volts, decay)))
    for has in (1, 2, 3, 4):
        file = replace(of_rig(one), quadrants=has)
        if has >= quadrants:
            refuse(one, file, program)
        else:
            with pytest.raises(RigError, match=r"^step 1 of the program (brakes|asks for -3 V)"):
                refuse(one, file, program)


def test_a_file_that_is_there_stays_unless_told(tmp_path: Path) -> None:
    opened, path = Opened(), tmp_path / "a.h5"
    path.write_bytes(b"mine")
    with pytest.raises(UsageError, match="exists"):
        opened.run(polled(tmp_path), path)
    assert (path.read_bytes(), opened.opened) == (b"mine", [])
    opened.run(polled(tmp_path), path, force=True)
    assert len(store.load(path)) > 2


# -- what is kept and raised, by how a run ends
class Ended:
    """A run that ends as it is told, with a bench, a poller and a file that are made."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.stop: Any = SimpleNamespace(requested=False)
        self.told, self.saved, self.offs = list[Any](), list[Any](), 0
        self.made: Callable[[], Any] = lambda: [1, 2, 3]
        self.off: Callable[[], None] = lambda: None
        supply = SimpleNamespace(settings={"current_limit": 4.0}, off=self._off)
        file = SimpleNamespace(channels="channels", text="the file")
        self.bench: Any = SimpleNamespace(
            identities=lambda: {"supply": "S"}, supply=supply, meters="meters", file=file,
            clock="clock", rig="rig", recorder=None,
        )  # fmt: skip
        patch.setattr(room, "Poller", lambda *words: SimpleNamespace(recording=lambda: words))
        patch.setattr(room, "capture_of", self._capture)
        patch.setattr(room.store, "save", lambda *words: self.saved.append(words))
        self._patch = patch

    def _off(self) -> None:
        self.offs += 1
        self.off()

    def _capture(self, one: Any, recording: Any, told: Told) -> Any:
        assert (one, recording) == (
            "rig", (self.bench.supply, "meters", "channels", "clock")
        )  # fmt: skip
        self.told.append(told)
        return self.made()

    def record(self, end: str | BaseException) -> None:
        def measure(run: _Run, poller: Any) -> str:
            run.commanded.append({"step": 0})
            run.limited.append(4)
            if isinstance(end, BaseException):
                raise end
            return end

        self._patch.setattr(_Run, "_measure", measure)
        _Run(self.bench, SHORT, self.stop, None).record(Path("a.h5"), True, "M1", "a note")


@pytest.fixture
def ended(monkeypatch: pytest.MonkeyPatch) -> Ended:
    return Ended(monkeypatch)


KEPT = "; 3 samples are kept in a.h5"


def test_a_whole_run_is_saved_with_what_happened(ended: Ended) -> None:
    ended.record("completed")
    (told,) = ended.told
    assert told == Told(
        "completed", told.created, "M1", "a note", {"supply": "S"}, {"current_limit": 4.0},
        [{"step": 0}], [4], SHORT.duration_s, "the file",
    )  # fmt: skip
    assert ended.saved == [([1, 2, 3], Path("a.h5"), True)]
    assert ended.offs == 1


@pytest.mark.parametrize(
    ("error", "reason"),
    [(LinkError("lost"), "link lost"), (RigError("no"), "stopped"), (DataError("x"), "stopped")],
)
def test_an_error_is_raised_with_what_is_kept(error: Exception, reason: str, ended: Ended) -> None:
    with pytest.raises(type(error), match=f"^{error}{KEPT}$"):
        ended.record(error)
    assert (ended.told[0].end_reason, ended.offs) == (reason, 1)


@pytest.mark.parametrize("kind", [DataError, LinkError])
def test_what_cannot_be_kept_is_said_after_what_ended_the_run(
    kind: type[Exception], ended: Ended
) -> None:
    def fails() -> None:
        raise kind("nothing to keep")

    ended.made = fails
    with pytest.raises(kind, match=r"^nothing to keep$"):
        ended.record("completed")
    with pytest.raises(RigError, match=r"^no; nothing to keep$"):
        ended.record(RigError("no"))
    assert ended.saved == []


def test_a_trip_or_a_stop_is_raised(ended: Ended) -> None:
    with pytest.raises(RigError, match=rf"^the supply ended the run \(fault: x\){KEPT}$"):
        ended.record("fault: x")
    ended.stop.requested = True
    with pytest.raises(KeyboardInterrupt, match=f"^interrupted{KEPT}$"):
        ended.record("interrupted")
    assert [told.end_reason for told in ended.told] == ["fault: x", "interrupted"]


# -- off, at last
def test_an_output_that_cannot_be_seen_off_is_what_is_said(ended: Ended) -> None:
    def unseen() -> None:
        raise LinkError("IT MAY BE ON")

    ended.off = unseen
    with pytest.raises(LinkError, match=rf"^no\. IT MAY BE ON{KEPT}$"):
        ended.record(RigError("no"))
    with pytest.raises(LinkError, match=f"^IT MAY BE ON{KEPT}$"):
        ended.record(ZeroDivisionError())
    with pytest.raises(LinkError, match=f"^IT MAY BE ON{KEPT}$"):
        ended.record("completed")
    assert {told.end_reason for told in ended.told} == {"link lost"}


def test_an_error_of_the_caller_s_own_is_raised_once_it_is_off(ended: Ended) -> None:
    with pytest.raises(ZeroDivisionError):
        ended.record(ZeroDivisionError())
    assert (ended.offs, ended.told) == (1, [])


@pytest.mark.parametrize(("presses", "offs"), [(1, 2), (4, 5), (5, 5), (9, 5)])
def test_switching_off_outlives_ctrl_c(presses: int, offs: int, ended: Ended) -> None:
    def pressed() -> None:
        if ended.offs <= presses:
            raise KeyboardInterrupt

    ended.off = pressed
    with pytest.raises(KeyboardInterrupt):
        ended.record("completed")
    assert ended.offs == offs


# -- the bench
def test_a_question_costs_a_round_trip(tmp_path: Path) -> None:
    opened = Opened(reply_s=0.25)
    one = polled(tmp_path)
    with _Bench(one, of_rig(one), opened, opened.clock) as bench:
        assert bench.round_trip_s() == pytest.approx(0.25)
        assert bench.recorder is None
        assert opened.of("supply OUTP OFF") != []
    assert opened.links[0].closed


def test_a_step_in_which_the_supply_limits_at_last_is_kept() -> None:
    supply = SimpleNamespace(limited=lambda: True, tripped=lambda: "", is_on=lambda: True)
    bench: Any = SimpleNamespace(supply=supply)
    made = _Run(bench, SHORT, SimpleNamespace(requested=False), None)  # type: ignore[arg-type]
    assert (made._ended(1), made.limited) == ("", [])  # the output is off
    made.live = True
    assert (made._ended(1), made._ended(1), made.limited) == ("", "", [1])
