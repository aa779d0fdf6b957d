"""What numbers in the files of instruments may be: each bound, and a little beyond it."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motorid.acquire.scpi import bench_file, dialect
from motorid.acquire.scpi import recorder as recording
from motorid.acquire.scpi.bench_file import BenchFile, Source, of_rig
from motorid.acquire.scpi.link import Instrument
from motorid.acquire.scpi.recorder import Clock, Recorder
from motorid.errors import LinkError, RigError
from motorid.rig_model import Rig
from tests.acquire.rigs import sim_rig
from tests.scpi.rigs import SCOPE_DIALECT
from tests.scpi.test_readings import Answers
from tests.scpi.test_readings import dialect as made

SUPPLY = '[supply]\nresource = "S"\n'
CHANNELS = "[channels.current]\n{one}\n[channels.terminal_voltage]\n{other}\n"
SOURCES = CHANNELS.format(one='source = "1"', other='source = "2"')
RECORDER = '[recorder]\nresource = "R"\ndialect = "scope.toml"\n'


def bench(folder: Path, section: str, line: str) -> BenchFile:
    """A bench with one line more in a section."""
    (folder / "scope.toml").write_text(SCOPE_DIALECT)
    supply = SUPPLY + (line if section == "supply" else "") + "\n"
    if section == "recorder":
        text = f"{supply}{RECORDER}{line}\n{SOURCES}"
    elif section == "meters":
        text = f'{supply}[meters.m]\nresource = "M"\n{line}\n'
    else:
        text = supply + CHANNELS.format(one=line if section == "channels" else "", other="")
    return bench_file.parse(text, folder / "bench.toml")


@pytest.mark.parametrize(
    ("section", "key", "low", "high"),
    [
        ("supply", "timeout_s", 0.01, 600), ("supply", "quadrants", 1, 4),
        ("meters", "timeout_s", 0.01, 600), ("recorder", "timeout_s", 0.01, 600),
        ("recorder", "lead_s", 0, 60), ("recorder", "clock_uncertainty", 0, 0.01),
        ("channels", "field", 0, 100), ("channels", "scale", -1e9, 1e9),
        ("channels", "zero", -1e9, 1e9), ("channels", "gain_uncertainty", 0, 1),
        ("channels", "offset_uncertainty", 0, 1e4),
    ],
)  # fmt: skip
def test_a_number_of_a_bench_lies_within_its_bounds(
    section: str, key: str, low: float, high: float, tmp_path: Path
) -> None:
    for good in (low, high):
        bench(tmp_path, section, f"{key} = {good}")
    for bad in (low - 1e-3 * max(1.0, abs(low)), high + 1e-3 * max(1.0, abs(high))):
        with pytest.raises(RigError, match=key):
            bench(tmp_path, section, f"{key} = {bad}")


def test_what_a_recorder_s_section_says_or_leaves_out(tmp_path: Path) -> None:
    found = bench(tmp_path, "recorder", "lead_s = 2\nclock_uncertainty = 1e-4\ntimeout_s = 7")
    assert (found.lead_s, found.clock_uncertainty) == (2.0, 1e-4)
    assert found.recorder is not None
    assert (found.recorder.resource, found.recorder.timeout_s) == ("R", 7.0)
    assert found.recorder_dialect is not None
    assert [one.sources for one in found.channels] == [("1",), ("2",)]
    bare = bench(tmp_path, "recorder", "")
    assert (bare.lead_s, bare.clock_uncertainty) == (0.1, 5e-5)
    assert bench(tmp_path, "meters", "").meters["m"].error == "SYST:ERR?"


def test_the_file_of_a_rig_is_beside_it_or_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def rig(port: str, folder: str | None = None) -> Rig:
        return Rig(**{**vars(sim_rig()), "port": port, "folder": folder or ""})

    with pytest.raises(RigError, match=r"port scpi://: name the file of the instruments"):
        of_rig(rig("scpi://"))
    beside, here = tmp_path / "beside", tmp_path / "here"
    for folder in (beside, here):
        folder.mkdir()
        (folder / "one.toml").write_text(SUPPLY + f'channel = "{folder.name}"\n')
    (here / "other.toml").write_text(SUPPLY)
    monkeypatch.chdir(here)
    assert of_rig(rig("scpi://one.toml", str(beside))).channel == "beside"
    assert of_rig(rig("scpi://one.toml")).channel == "here"
    assert of_rig(rig("scpi://other.toml", str(beside))).channel == "1"
    with pytest.raises(RigError, match="absent"):
        of_rig(rig("scpi://absent.toml", str(beside)))


def test_sections_are_tables(tmp_path: Path) -> None:
    for name in ("channels", "meters"):
        with pytest.raises(RigError, match=rf"\[{name}\] must be a table, not 5"):
            bench_file.parse(f"{name} = 5\n{SUPPLY}", tmp_path / "bench.toml")


# -- dialects
ACQUIRE = 'kind = "recorder"\n[acquire]\nstart = ["GO"]\n{acquire}\n'
WAVEFORM = '[waveform]\npreamble = "P"\ndata = "D"\ntype = "H"\n{waveform}\n'
TALK = (
    'kind = "supply"\n[voltage]\nset = "V {{value}}"\nask = "V?"\n'
    '[current_limit]\nset = "I {{value}}"\nask = "I?"\n[output]\non = "1"\noff = "0"\nask = "O?"\n'
    "{more}\n"
)


def words(section: str, line: str) -> dialect.Dialect:
    text = (ACQUIRE + WAVEFORM).format(
        acquire=line if section == "acquire" else "", waveform=line if section == "waveform" else ""
    )
    if section in ("limiting", "measure"):
        text = TALK.format(more=f"[{section}]\n{line}")
    return dialect.parse(text, "mine.toml")


@pytest.mark.parametrize(
    ("section", "key", "low", "high"),
    [
        ("acquire", "mask", 1, 2**31), ("acquire", "value", 0, 2**31),
        ("waveform", "raw_min", -(2**31), 2**31), ("waveform", "raw_max", -(2**31), 2**31),
        ("limiting", "mask", 1, 2**31), ("measure", "current_field", 0, 100),
        ("measure", "terminal_voltage_field", 0, 100),
    ],
)  # fmt: skip
def test_a_number_of_a_dialect_lies_within_its_bounds(
    section: str, key: str, low: int, high: int
) -> None:
    for good in (low, high):
        assert words(section, f"{key} = {good}").get(section, key) == good
    for bad in (low - 1, high + 1):
        with pytest.raises(RigError, match=key):
            words(section, f"{key} = {bad}")


def test_a_dialect_that_is_silent_is_called_by_its_file() -> None:
    found = words("limiting", "")
    assert (found.kind, found.name, found.error, found.prepare) == (
        "supply", "mine", "SYST:ERR?", ()
    )  # fmt: skip
    assert (found.get("limiting", "ask"), found.get("odd", "ask")) == ("", "")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('name = "x"\n', 'kind is missing: write kind = "supply" or "recorder"'),
        (TALK.format(more="[waveform]"), "unknown"),
        (TALK.format(more="").replace('ask = "V?"', ""), "voltage.ask is missing"),
        (TALK.format(more="").replace('off = "0"', ""), "output.off is missing"),
        (ACQUIRE.format(acquire=""), "waveform.preamble is missing"),
        (ACQUIRE.format(acquire="").replace('start = ["GO"]', ""), "acquire.start is missing"),
        (ACQUIRE.format(acquire="") + '[scan]\ndata = "D"', "scan.elements is missing"),
        (
            ACQUIRE.format(acquire="") + '[scan]\ndata = "D"\nelements = ["reading", "time"]',
            "scan.elements must hold 'channel' once",
        ),
        (TALK.format(more='[limiting]\nask = "{odd}"'), "'odd' is no field; known: value"),
        (TALK.format(more='[limiting]\nask = "{"'), "'{' is no field"),
        (ACQUIRE.format(acquire='stop = ["{odd}"]') + WAVEFORM.format(waveform=""), "'odd' is no"),
        ('prepare = ["{odd}"]\n' + TALK.format(more=""), "'odd' is no field"),
    ],
)
def test_a_dialect_that_cannot_work(text: str, says: str) -> None:
    with pytest.raises(RigError, match=f"^mine.toml: .*{says}"):
        dialect.parse(text, "mine.toml")


# -- a recorder that scans, and its clock
def scanned(scans: int, level: Any) -> recording.Recording:
    """Two inputs, read .1 s after one another, twice a second."""
    rows = [f"{level(n, k)},{0.5 * n + 0.1 * k},{101 + k}" for n in range(scans) for k in range(2)]
    sources = (
        Source("current", ("101",), scale=-2.0, zero=5.0),
        Source("terminal_voltage", ("102",)),
    )
    facts = {"data": "FETCH?", "elements": ("reading", "time", "channel")}
    link = Answers(**{"FETCH?": ",".join(rows)})
    return Recorder(Instrument("daq", link, ""), made(scan=facts), sources, 3e-5).recording()


def test_scans_become_traces() -> None:
    found = scanned(3, lambda n, k: 10 * n + k)
    current, volts = found.traces
    assert current.scale * (current.raw - current.offset) == pytest.approx([10.0, -10.0, -30.0])
    assert volts.raw.tolist() == [1.0, 11.0, 21.0]
    assert current.late is not None
    assert volts.late is not None
    assert current.late[0] == pytest.approx(0.1)
    assert volts.late[0] == pytest.approx(0.0)
    assert current.late[1] == volts.late[1] > 0.0
    assert found.time_s == pytest.approx([0.0, 0.5, 1.0])
    assert (found.clock_uncertainty, found.uniform, found.polled) == (3e-5, False, False)
    (note,) = found.notes
    assert "reads its inputs one after another" in note


def test_readings_in_steps_are_resolved_to_these() -> None:
    found = scanned(24, lambda n, k: "9.91E37" if n == 7 else 10 * (n % 3) + k)
    current, volts = found.traces
    assert (current.resolution, volts.resolution) == (pytest.approx(20.0), pytest.approx(10.0))
    assert (found.uniform, found.time_s[-1]) == (True, pytest.approx(11.5))
    assert found.clock_uncertainty >= 3e-5


def test_a_recorder_s_clock_is_this_computer_s(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    time = SimpleNamespace(monotonic=lambda: 12.5, sleep=slept.append)
    monkeypatch.setattr(recording, "time", time)
    clock = Clock()
    clock.sleep(0.25)
    clock.sleep(-1.0)
    assert (clock.now(), slept) == (12.5, [0.25, 0.0])


# -- one instrument
def test_an_instrument_that_does_not_say_who_it_is() -> None:
    with pytest.raises(LinkError, match=r"^the dmm answers \*IDN\? with nothing: is it a SCPI"):
        Instrument("dmm", Answers(**{"*IDN?": " "})).identify()
    link = Answers(**{"*IDN?": " me ", "E?": ['-1,"old"', "0"]})
    dmm = Instrument("dmm", link, "E?")
    assert dmm.identify() == dmm.identity == "me"
    assert link.heard == ["*IDN?", "*CLS", "E?", "E?"]


class Silent(Answers):
    """A link that answers its error queue alone."""

    def ask(self, text: str) -> str:
        if text != "E?":
            raise LinkError("no answer")
        return super().ask(text)

    def block(self, text: str, kind: str, big_endian: bool) -> Any:
        raise LinkError("no block")


@pytest.mark.parametrize(
    ("queue", "more"),
    [(['-1,"odd"', "0"], """; its error queue says -1,"odd\""""), (["0"], ""), (["what?"], "")],
)
def test_silence_is_explained_by_the_error_queue(queue: list[str], more: str) -> None:
    for ask, says in (("ask", "no answer"), ("block", "no block")):
        one = Instrument("dmm", Silent(**{"E?": list(queue)}), "E?")
        with pytest.raises(LinkError) as e:
            getattr(one, ask)(*("Q?", "H")[: 1 + (ask == "block")])
        assert str(e.value) == says + more


def test_numbers_and_blocks() -> None:
    link = Answers(**{"Q?": "1, 2.5,-3", "B?": [1, 2], "N?": []})
    one = Instrument("dmm", link, "")
    assert one.numbers("Q?") == [1.0, 2.5, -3.0]
    assert math.isnan(Instrument("dmm", Answers(**{"Q?": "9.91E37"}), "").number("Q?"))
    np.testing.assert_array_equal(one.block("B?", "h", True), [1, 2])
    assert link.heard[-1] == "B? h True"
    with pytest.raises(LinkError, match=r"the dmm answers 'N\?' with no reading"):
        one.block("N?", "H")
    assert link.heard[-1] == "N? H False"
