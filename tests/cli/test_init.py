"""motorid init: from the parts of a bench to its files, the board's facts, and a first pulse."""

from __future__ import annotations

import io
from pathlib import Path

import pytest

from motorid.acquire import front_end, ports
from motorid.cli import init as page
from motorid.cli.main import run
from motorid.errors import RigError, UsageError
from motorid.rig import load_rig
from motorid.rig_front_end import load_front_end, presets
from motorid.sim.front_end import compiled
from motorid.sim.port import SimPort, open_sim
from motorid.wire.enums import Bridge, ResetCause, Sensor
from motorid.workflow import init, kit
from motorid.workflow.kit import Answers

BENCH = "sim://?motor=maxon-amax22&speed=max&bridge_drop=1.4&bridge_resistance=1.15&supply=12"
PARTS = ("--board", "other", "--driver", "l298n", "--sensor", "acs712-05", "--counts", "2048")
MOTOR = ("--supply", "12", "--motor", "A-max 22", "--volts", "12", "--rpm", "10200")
ALL = (*PARTS, *MOTOR, "--yes")
SAID = Answers("other", BENCH, "l298n", "acs712-05", 2048, 12.0, "A-max 22", 12.0)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def answer(monkeypatch: pytest.MonkeyPatch, *lines: str) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{line}\n" for line in lines)))


def test_with_options_alone_the_files_are_written_and_nothing_moves(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["init", "--port", BENCH, *ALL]) == 0
    rig = load_rig("bench.toml")
    assert (rig.limits.current_a, rig.wiring.counts_per_turn) == (2.0, 2048)
    assert (rig.wiring.bridge_drop_v, rig.wiring.bridge_resistance_ohm) == (1.4, 1.15)
    assert rig.wiring.terminal_load_ohm == 0.0  # nobody knows this board's front end
    assert load_front_end("bench-front-end.toml").facts["bridge"] == Bridge.BIPOLAR
    assert "the motor was not moved" in capsys.readouterr().out
    assert sorted(path.name for path in folder.iterdir()) == ["bench-front-end.toml", "bench.toml"]


def test_questions_are_asked_again_until_the_answer_is_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answer(
        monkeypatch, "other", "l298x", "l298n", "nobody", "acs712-05", "-3", "2048", "12",
        "A-max 22", "", "fast", "10200", "", "4.93", "y",
    )  # fmt: skip
    assert run(["init", "--port", BENCH]) == 0
    said = capsys.readouterr().out
    assert "no front-end file 'nobody'" in said
    assert "'fast' is no number above 0" in said
    for word in ("signs    right", "counts  ", "current ", "zero    ", "voltage ", "supply  "):
        assert word in said
    assert load_rig("bench.toml").nameplate.resistance_ohm is None
    assert load_front_end("bench-front-end.toml").facts["reference_v"] == pytest.approx(4.93)


@pytest.mark.parametrize("lines", [(), ("uno", "l298n"), ("uno", "l298n", "acs712-05", "64", "12")])
def test_answers_that_end_early_leave_nothing(
    lines: tuple[str, ...], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer(monkeypatch, *lines)
    assert run(["init", "--port", BENCH]) == 2
    assert not list(folder.iterdir())


def test_without_a_yes_the_motor_stands(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(init, "verdict", lambda *_: pytest.fail("it drove"))
    answer(monkeypatch, "", "n")
    assert run(["init", "--port", BENCH, *PARTS, *MOTOR, "--resistance", "5.5"]) == 0
    assert run(["init", "--port", BENCH, *ALL, "--force"]) == 0


@pytest.mark.slow
def test_an_encoder_that_counts_backwards_is_turned_round(
    capsys: pytest.CaptureFixture[str],
) -> None:
    port = f"{BENCH}&fault=encoder_reversed"
    assert run(["init", "--port", port, *ALL, "--pulse"]) == 0
    assert load_rig("bench.toml").encoder_reversed
    assert "signs    right" in capsys.readouterr().out


def test_a_wrong_scale_is_named_and_the_bench_is_not_called_ready(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A quarter of the encoder's counts was stated."""
    fine = [word.replace("2048", "512") for word in ALL]
    assert run(["init", "--port", BENCH, *fine, "--rpm", "10200", "--pulse"]) == 3
    said = capsys.readouterr()
    assert "counts   wrong: " in said.out
    assert "signs    right" in said.out
    assert "the bench is ready" not in said.out
    assert "the pulse shows something wrong (counts)" in said.err


def test_what_the_pulse_finds_wrong_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    port = f"{BENCH}&fault=current_dead"
    assert run(["init", "--port", port, *ALL, "--pulse"]) == 3
    assert "the current sensor reads" in capsys.readouterr().err
    assert Path("bench.toml").is_file()


def test_files_that_are_there_stay(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "bench-front-end.toml").write_text("mine")
    assert run(["init", "--port", BENCH, *ALL]) == 2
    assert "bench-front-end.toml is there already" in capsys.readouterr().err
    assert [path.read_text() for path in folder.iterdir()] == ["mine"]


def test_a_stop_while_writing_leaves_neither_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = init.prepare(SAID, Path("bench.toml"), force=False, ask_board=False)

    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(init.os, "replace", stopped)
    with pytest.raises(KeyboardInterrupt):
        init.write(bench)
    assert not list(folder.iterdir())


WRONG: dict[str, tuple[tuple[str, ...], str]] = {
    "a missing answer": (("--port", BENCH, *PARTS, "--yes"), "--supply is missing"),
    "a sensor without a sign": ((*ALL, "--sensor", "vnh5019"), "shows no sign of the current"),
    "more than the driver": ((*ALL, "--most", "3"), "more than the driver l298n bears, 2 A"),
    "too fine an encoder": ((*ALL, "--counts", "20480000"), "edges a second, and the board counts"),
    "another motor's supply": ((*ALL, "--volts", "100"), "does not fit a motor of 100 V"),
    "no rig file": ((*ALL, "-o", "bench.txt"), "a rig file ends in .toml"),
    "a reference of another pin": ((*ALL, "--reference", "3.3"), "far from the 5 V of acs712-05"),
    "another board's sensor": ((*ALL, "--board", "pico"), "acs712-05 is that of uno or mega"),
    "a label of control characters": ((*ALL, "--motor", "a\x07b"), "cannot be printed"),
}


@pytest.mark.parametrize("why", WRONG)
def test_parts_that_do_not_fit_are_one_sentence(
    why: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words, says = WRONG[why]
    assert run(["init", "--port", BENCH, *words]) == 2
    assert says in capsys.readouterr().err
    assert not list(folder.iterdir())


@pytest.mark.slow
def test_every_driver_and_sensor_that_it_offers_makes_files_that_are_read() -> None:
    assert tuple(kit.DRIVERS) == page.DRIVERS
    assert kit.BOARDS == page.BOARDS
    for driver, facts in kit.DRIVERS.items():
        for sensor in presets():
            board = "pico" if "pico" in load_front_end(sensor).boards else "uno"
            said = Answers(board, "x", driver, sensor, 64, 12.0, 'a "12 V" motor', 12.0)
            if load_front_end(sensor).facts["sensor"] == Sensor.MAGNITUDE:
                with pytest.raises(UsageError, match="no sign"):
                    kit.kit(said, "bench", "front.toml")
                continue
            made = kit.kit(said, "bench", "front.toml")
            assert made.front_end.facts["bridge"] == Bridge[facts.bridge.upper()]
            assert made.rig.limits.current_a <= facts.most_a
            assert made.rig.front_end == "front.toml"


def test_a_pico_is_set_up_for_its_own_rate_and_sensor(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answer(monkeypatch, "pico", "drv8871", "", "2000", "12", "a motor", "12", "", "", "", "", "")
    assert run(["init", "--offline"]) == 0
    rig, front_end = load_rig("bench.toml"), load_front_end("bench-front-end.toml")
    assert rig.sampling.rate_hz == 20_000
    assert (front_end.name, front_end.facts["bridge"]) == ("pico-ina240", Bridge.IN_IN)
    assert "V by a meter" not in capsys.readouterr().out  # an LM4040 is no supply


@pytest.mark.parametrize("board", ["uno", "nano", "mega", "pico"])
def test_the_dividers_behind_the_current_sensor_are_declared(board: str) -> None:
    """10 kohm and what 1.54 kohm and 20 kohm side by side are, from each lead to ground."""
    sensor = "pico-ina240" if board == "pico" else "acs712-05"
    said = Answers(board, "x", "l298n", sensor, 64, 12.0, "a motor", 12.0)
    wiring = kit.kit(said, "bench", "front.toml").rig.wiring
    if board == "pico":  # an amplifier's inputs, of which no file says the ohms
        assert wiring.terminal_load_ohm == 0.0
        return
    one = 10e3 + 1 / (1 / 1.54e3 + 1 / 20e3)
    low, high = (wiring.terminal_load_ohm + k * wiring.terminal_load_uncertainty_ohm
                 for k in (-2.0, 3.0))  # fmt: skip
    assert low < one < 2 * one < high


def test_a_measured_reference_scales_what_follows_it() -> None:
    """A ratiometric sensor's zero and gain, and the lift; other gains and dividers stay."""
    for sensor, volts in (("acs712-05", 4.8), ("pico-3v3-ina240", 3.2)):
        board = "pico" if sensor.startswith("pico") else "uno"
        said = Answers(board, "x", "l298n", sensor, 64, 12.0, "a motor", 12.0, reference_v=volts)
        old, new = (
            load_front_end(sensor).facts,
            kit.kit(said, "bench", "front.toml").front_end.facts,
        )
        share = volts / old["reference_v"]
        assert new["reference_v"] == volts
        assert new["current_zero_v"] == pytest.approx(share * old["current_zero_v"], rel=1e-5)
        assert new["lift_v"] == pytest.approx(share * old["lift_v"], rel=1e-5)
        gain = share if old["ratiometric"] else 1.0
        assert new["current_v_a"] == pytest.approx(gain * old["current_v_a"], rel=1e-5)
        assert new["voltage_divider"] == old["voltage_divider"]
        assert new["voltage_gain_uncertainty"] < 0.5 * old["voltage_gain_uncertainty"]


def as_wired(board: SimPort) -> str:
    """A front-end file that says of the simulated bench what is so."""
    assert board._device.board is not None
    facts = compiled(board._device.board.chain)
    return f"""
name = "as wired"
sensor = "shunt"
[converter]
reference_v = {facts["reference_v"]}
reference_uncertainty = 0.001
[current]
volts_per_ampere = {facts["current_v_a"]}
zero_v = {facts["current_zero_v"]}
zero_uncertainty_v = 0.001
gain_uncertainty = 0.002
most_a = 5
[voltage]
divider = {facts["voltage_divider"]}
supply_divider = {facts["supply_divider"]}
lift_v = {facts["lift_v"]}
gain_uncertainty = 0.001
"""


def test_a_board_gets_its_facts_and_is_driven_by_them(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A board that remembers, behind a name that is no simulator's."""
    board = open_sim(BENCH)
    monkeypatch.setattr(board, "close", lambda: None)
    Path("wired.toml").write_text(as_wired(board))
    own = [word.replace("acs712-05", "wired.toml") for word in ALL]

    def opened(url: str) -> SimPort:
        if url != "/dev/board":
            raise RigError(f"{url} is another port")
        found = board._device.board
        assert found is not None
        found.reset(ResetCause.EXTERNAL)
        return board

    for module in (init, front_end, ports):
        monkeypatch.setattr(module, "open_port", opened)
    monkeypatch.setattr(init, "only_port", lambda: "/dev/board")
    assert run(["init", *own, "--pulse"]) == 0
    said = capsys.readouterr().out
    assert "facts of the front end are stored" in said
    assert "signs    right" in said
    rig = load_rig("bench.toml")
    assert (rig.port, rig.front_end) == ("/dev/board", "bench-front-end.toml")
    found = board._device.board
    assert found is not None
    assert found.front_end.hash == load_front_end("bench-front-end.toml").hash
    uno = [word if word != "other" else "uno" for word in own]
    assert run(["init", *uno, "--force"]) == 2
    assert "answers, and not a uno: name the right board" in capsys.readouterr().err
