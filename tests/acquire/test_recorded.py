"""What a run leaves behind, by its end: file, journal and sentence; all around it is made."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motorid.acquire import record as room
from motorid.acquire.assemble import NoPlaceError, NoSamplesError
from motorid.acquire.interrupt import Stop
from motorid.acquire.keep import Kept
from motorid.acquire.resets import reset_error
from motorid.acquire.signs import Sign, SignError
from motorid.errors import DataError, LinkError, RigError, UsageError
from motorid.program import Rotor
from motorid.wire.enums import ResetCause
from tests.acquire.rigs import sim_rig

RIG = sim_rig()


class Journal:
    """A journal that notes what becomes of it."""

    def __init__(self, path: Path, header: Any) -> None:
        self.path, self.header, self.did = path, header, list[Any]()

    def mark(self, time_s: float, **what: Any) -> None:
        self.did.append((time_s, what))

    def close(self) -> None:
        self.did.append("closed")

    def discard(self) -> None:
        self.did.append("discarded")


class Bench:
    """A recorder whose run ends as it is told, and what it did with journal and file."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self.path, self.journals = folder / "run.h5", list[Journal]()
        self.port: Any = SimpleNamespace(name="port", now=lambda: 12.5)
        self.stop, self.trip, self.program = Stop(), "told", RIG.program
        self.keeps: Callable[[], Kept] = lambda: Kept(5)
        self.kept, self.aside, self.boards = list[Any](), list[Any](), list[Any]()
        self.room = list[Path]()
        patch.setattr(room, "JournalWriter", self._journal)
        patch.setattr(room, "JournaledPort", lambda port, journal: (port, journal))
        patch.setattr(room, "Board", self._board)
        patch.setattr(room, "keep", self._keep)
        patch.setattr(room, "make_way", self.room.append)
        patch.setattr(room, "set_aside", self._aside)
        self._patch = patch

    def _journal(self, path: Path, header: Any) -> Journal:
        self.journals.append(Journal(path, header))
        return self.journals[-1]

    def _board(self, *words: Any) -> Any:
        self.boards.append(words)
        return SimpleNamespace(trip=self.trip)

    def _keep(self, journal: Path, path: Path, force: bool) -> Kept:
        self.kept.append((journal, path, force))
        return self.keeps()

    def _aside(self, path: Path, why: str) -> Path:
        self.aside.append((path, why))
        return Path("aside")

    def record(self, end: str | BaseException, *, force: bool = False) -> list[Any]:
        """One run that ends so; what became of its journal."""

        def measure(recorder: Any, board: Any, journal: Journal, checked: bool) -> str:
            assert (board.trip, journal, checked) == (self.trip, self.journals[-1], True)
            if isinstance(end, BaseException):
                raise end
            return end

        self._patch.setattr(room._Recorder, "_measure", measure)
        made = room._Recorder(self.port, RIG, self.program, self.stop, None)
        made.record(self.path, force, "M1", "a note", checked=True)
        return self.journals[-1].did


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(tmp_path, monkeypatch)


KEPT = r"; 5 samples are kept in .*run\.h5$"


def test_a_whole_run_leaves_its_file(bench: Bench) -> None:
    assert bench.record("completed") == [(12.5, {"end": "completed"}), "closed", "discarded"]
    (journal,) = bench.journals
    assert journal.path == bench.path.with_name("run.h5.journal")
    assert (journal.header["serial"], journal.header["note"]) == ("M1", "a note")
    assert bench.boards == [((bench.port, journal), journal.header["first_request"])]
    assert (bench.kept, bench.room) == ([(journal.path, bench.path, False)], [])
    json.dumps(journal.header)
    bench.record("completed", force=True)
    assert (bench.kept[1][2], bench.room) == (True, [bench.path])


@pytest.mark.parametrize(
    ("error", "end"),
    [
        (LinkError("lost"), "link lost"),
        (reset_error("port", ResetCause.EXTERNAL, "in use"), "reset: external"),
        (RigError("wrong"), ""),
    ],
)
def test_what_ended_a_run_early_is_raised_with_what_is_kept(
    error: Exception, end: str, bench: Bench
) -> None:
    with pytest.raises(type(error), match=f"^{error}".replace("(", r"\(").replace(")", r"\)")) as e:
        bench.record(error)
    assert e.match(KEPT)
    assert type(e.value) is type(error)
    assert getattr(e.value, "cause", None) == ("external" if "reset" in end else None)
    marked = [(12.5, {"end": end})] if end else []
    assert bench.journals[0].did == [*marked, "closed", "discarded"]


def test_an_error_of_the_caller_s_own_stays_as_it_is(bench: Bench) -> None:
    error = ZeroDivisionError("mine")
    with pytest.raises(ZeroDivisionError) as e:
        bench.record(error)
    assert e.value is error
    assert bench.journals[0].did[0] == (12.5, {"end": "interrupted"})


@pytest.mark.parametrize(
    ("name", "sign"),
    [
        ("over_current", Sign.OVER_CURRENT), ("over_speed", Sign.OVER_SPEED), ("supply_low", None),
    ],
)  # fmt: skip
def test_a_trip_is_said_with_what_the_board_told(
    name: str, sign: Sign | None, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room.store, "load", lambda path: (path, "loaded"))
    monkeypatch.setattr(room, "why_too_fast", lambda rig, run: f"; {run[1]}" if rig is RIG else "")
    with pytest.raises(RigError, match=rf"^the board tripped \({name}: told\)") as e:
        bench.record(f"fault: {name}")
    assert e.match(KEPT)
    assert ("; loaded; 5 samples" in str(e.value)) is (name == "over_speed")
    assert (e.value.sign if isinstance(e.value, SignError) else None) == sign


def test_a_held_rotor_that_moved_is_said(bench: Bench) -> None:
    bench.program = replace(RIG.program, rotor=Rotor.CLAMPED)
    with pytest.raises(RigError, match=r"^the rotor moved, and the board opened the bridge") as e:
        bench.record("fault: over_speed")
    assert e.match(KEPT)
    with pytest.raises(RigError, match=r"tripped \(over_current"):
        bench.record("fault: over_current")


def test_a_trip_without_a_sample_has_no_speed_to_judge(bench: Bench) -> None:
    bench.keeps = lambda: Kept(0)
    with pytest.raises(RigError, match=r"^the board tripped \(over_speed: told\).*gear_ratio") as e:
        bench.record("fault: over_speed")
    assert "kept" not in str(e.value)


@pytest.mark.parametrize(
    ("samples", "says"), [(5, KEPT), (0, "^interrupted; nothing was measured$")]
)
def test_a_stop_is_said(samples: int, says: str, bench: Bench) -> None:
    bench.stop.requested = True
    bench.keeps = lambda: Kept(samples)
    with pytest.raises(KeyboardInterrupt, match=says):
        bench.record("interrupted")


def none(kind: type[DataError]) -> Callable[[], Kept]:
    def keeps() -> Kept:
        raise kind("nothing of it")

    return keeps


def test_a_run_without_a_sample_leaves_no_journal(bench: Bench) -> None:
    bench.keeps = none(NoSamplesError)
    with pytest.raises(LinkError, match=r"^port: the board says that the run is over, and not one"):
        bench.record("completed")
    assert bench.journals[0].did[-1] == "discarded"
    with pytest.raises(RigError, match=r"^wrong$"):
        bench.record(RigError("wrong"))


def test_samples_without_a_place_stay_in_the_journal(bench: Bench) -> None:
    bench.keeps = none(NoPlaceError)
    says = "nothing of it; they are kept as they came in aside: report it$"
    with pytest.raises(NoPlaceError, match=f"^{says}"):
        bench.record("completed")
    assert bench.aside == [(bench.journals[0].path, "raw")]
    assert "discarded" not in bench.journals[0].did
    with pytest.raises(RigError, match=f"^wrong; {says}"):
        bench.record(RigError("wrong"))
    bench.keeps = lambda: Kept(5, unplaced=True)
    assert bench.record("completed")[-1] == "closed"
    assert len(bench.aside) == 3


def test_a_file_that_cannot_be_written_leaves_the_journal(bench: Bench) -> None:
    bench.keeps = none(DataError)
    with pytest.raises(DataError, match=r"^nothing of it$"):
        bench.record("completed")
    with pytest.raises(LinkError, match=r"^lost; nothing of it$"):
        bench.record(LinkError("lost"))
    with pytest.raises(DataError, match=r"^nothing of it$"):
        bench.record(DataError("nothing of it"))  # and not twice
    assert all(journal.did[-1] == "closed" for journal in bench.journals)


def test_a_replay_ends_as_its_journal_does(bench: Bench) -> None:
    bench.port.header, bench.port.end = {"note": "of yore", "first_request": 77}, "stopped"
    assert bench.record("completed")[0] == (12.5, {"end": "stopped"})
    assert bench.journals[0].header == bench.port.header
    assert bench.boards[0][1] == 77
    bench.port.end = None
    assert bench.record("completed") == ["closed", "discarded"]
    bench.port.header = {}
    bench.record("completed")
    assert bench.boards[1][1] == 77


# -- a second Ctrl-C
def quits(bench: Bench, error: BaseException, *, measuring: bool) -> None:
    made = room._Recorder(bench.port, RIG, RIG.program, bench.stop, None)
    made.measuring = measuring
    bench.journals.append(Journal(bench.path, {}))
    made._quit(error, bench.journals[0])  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("measuring", "says", "did"),
    [
        (False, r"^interrupted twice; nothing was measured$", ["closed", "discarded"]),
        (True, r"^interrupted twice; `motorid recover .*run\.h5` keeps what arrived$", ["closed"]),
    ],
)
def test_a_second_request_quits_at_once(
    measuring: bool, says: str, did: list[str], bench: Bench
) -> None:
    with pytest.raises(KeyboardInterrupt, match=says) as e:
        quits(bench, KeyboardInterrupt(), measuring=measuring)
    assert e.value.__suppress_context__
    assert bench.journals[0].did == did
    with pytest.raises(SystemExit):
        quits(bench, SystemExit(1), measuring=measuring)


def test_a_disk_that_is_full_keeps_nobody_from_quitting(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(journal: Journal) -> None:
        raise DataError("no room")

    monkeypatch.setattr(Journal, "close", full)
    with pytest.raises(KeyboardInterrupt, match="keeps what arrived"):
        quits(bench, KeyboardInterrupt(), measuring=True)


def test_a_run_that_is_quit_keeps_nothing(bench: Bench) -> None:
    with pytest.raises(KeyboardInterrupt, match="interrupted twice; nothing was measured"):
        bench.record(KeyboardInterrupt())
    assert (bench.kept, bench.journals[0].did) == ([], ["closed", "discarded"])


# -- several runs, and one over an open port
@pytest.fixture
def runs(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What is recorded in place of runs: path, whether checked, who is told, what is said."""
    found: list[Any] = []

    def record(made: Any, path: Path, force: bool, *texts: str, checked: bool) -> None:
        assert made.program is RIG.program
        found.append((path.name, force, texts, checked, made.say, made.progress, made.watch))

    monkeypatch.setattr(room._Recorder, "record", record)
    return found


def test_the_first_of_several_runs_checks_and_says_what_contradicts(
    runs: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    closed: list[str] = []
    port = SimpleNamespace(name="port", close=lambda: closed.append("closed"))
    monkeypatch.setattr(room, "open_port", lambda url: port if url == RIG.port else None)
    say, seen, watch = print, repr, ascii
    paths = [tmp_path / "a.h5", tmp_path / "b.h5"]
    made = room.capture_all(
        RIG, RIG.program, paths, serial="S", note="N", say=say, progress=seen, watch=watch  # type: ignore[arg-type]
    )  # fmt: skip
    assert made == paths
    assert runs == [
        ("a.h5", False, ("S", "N"), False, say, seen, watch),
        ("b.h5", False, ("S", "N"), True, None, seen, watch),
    ]
    assert closed == ["closed"]
    assert room.capture(RIG, RIG.program, paths[0], force=True) == paths[0]
    assert runs[2] == ("a.h5", True, ("", ""), False, None, None, None)


def test_what_could_pass_a_limit_opens_no_port(
    runs: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "open_port", lambda url: 1 // 0)
    rig = replace(RIG, limits=replace(RIG.limits, run_time_s=0.01))
    with pytest.raises(RigError, match=r"limits\.run_time_s"):
        room.capture_all(rig, RIG.program, [tmp_path / "a.h5"])
    (tmp_path / "a.h5").write_bytes(b"mine")
    for capture in (room.capture, lambda *words: room.capture_over(object(), *words)):  # type: ignore[arg-type]
        with pytest.raises(UsageError, match="exists"):
            capture(RIG, RIG.program, tmp_path / "a.h5")
    assert runs == []


def test_a_run_over_an_open_port_leaves_it_open(runs: list[Any], tmp_path: Path) -> None:
    port: Any = SimpleNamespace(name="port")
    path, seen, watch = tmp_path / "a.h5", repr, ascii
    more: Any = {"progress": seen, "watch": watch}
    assert room.capture_over(port, RIG, RIG.program, path, serial="S", note="N", **more) == path
    assert runs == [("a.h5", False, ("S", "N"), False, None, seen, watch)]
    room.capture_over(port, RIG, RIG.program, path, force=True, checked=True)
    assert runs[1] == ("a.h5", True, ("", ""), True, None, None, None)
    rig = replace(RIG, limits=replace(RIG.limits, run_time_s=0.01))
    with pytest.raises(RigError, match=r"limits\.run_time_s"):
        room.capture_over(port, rig, RIG.program, path)


# -- limits that the board holds
def test_limits_are_read_back(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def ask(name: str, **fields: int) -> dict[str, int]:
        asked.append((name, fields))
        return {"config_hash": 1}

    board: Any = SimpleNamespace(
        ask=ask, identity={"protocol_minor": 3}, descriptors={}, port=SimpleNamespace(name="port")
    )
    monkeypatch.setattr(room, "configuration", lambda *what: {"mode": 1, "channels": 5})
    monkeypatch.setattr(room, "check", lambda *what: {"channels": 6, "front_end_hash": 2})
    monkeypatch.setattr(room, "differing", lambda sent, read, minor: "")
    assert room.configure(board, RIG, mode=4) == {"config_hash": 1}
    wanted = {"mode": 4, "channels": 6, "front_end_hash": 2}
    assert asked == [("configure", wanted), ("read_config", {})]

    def differs(sent: Any, read: Any, minor: int) -> str:
        assert (sent, read, minor) == (wanted, {"config_hash": 1}, 3)
        return "of mode"

    monkeypatch.setattr(room, "differing", differs)
    with pytest.raises(LinkError, match=r"^port: the board holds other limits than sent: of mode"):
        room.configure(board, RIG, mode=4)


@pytest.mark.parametrize(("rate_hz", "mode"), [(10_000.0, "burst"), (40_000.0, "stream")])
def test_a_fast_burst_s_zero_is_of_the_fastest_stream(rate_hz: float, mode: str) -> None:
    board: Any = SimpleNamespace(
        identity={
            "clock_hz": 1_000_000, "min_sample_period_ticks": 50, "burst_sample_period_ticks": 25,
            "sample_period_step_ticks": 1,
        }
    )  # fmt: skip
    rig = replace(RIG, sampling=replace(RIG.sampling, rate_hz=rate_hz, mode="burst"))
    found = room.streaming(rig, board).sampling
    assert (found.mode, found.rate_hz) == (mode, 10_000.0 if mode == "burst" else 20_000.0)
