"""What a look at a file says of its columns: by names, units and physics, and what it asks."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from motorid.capture.columns import Described
from motorid.capture.table_options import TableOptions
from motorid.errors import DataError, UsageError
from motorid.report import braille
from motorid.workflow.proposal import laws
from motorid.workflow.proposal.naming import allowed, meaning, words
from motorid.workflow.proposal.page import WIDTH, asked, command, page
from motorid.workflow.proposal.proposal import Proposal, look, propose
from motorid.workflow.proposal.question import NOTHING, Known, Question, of_maps
from motorid.workflow.proposal.vocabulary import INDEX, OTHER
from tests.capture_import.corpus.bench_log import RPM, columns, log, text

TUV = {"time": 1.0, "voltage": 1.0, "current": 1.0}


def write(folder: Path, head: str, table: np.ndarray) -> Path:
    path = folder / "log.csv"
    path.write_text(text(head + "\n" if head else "", table), encoding="utf-8")
    return path


def of(folder: Path, head: str, table: np.ndarray, known: Known = NOTHING) -> Proposal:
    return propose(look(write(folder, head, table), TableOptions()), known)


def units(proposal: Proposal) -> dict[str, str]:
    return {m.partition("=")[0]: m.rpartition(":")[2] for m in proposal.maps}


@pytest.mark.parametrize(
    ("name", "quantity", "unit"),
    [
        ("Motorstrom [mA]", "current", "mA"),
        ("I_A", "current", "A"),
        ("phase_A", OTHER, ""),
        ("omega_rad_s", "speed", "rad/s"),
        ("Drehzahl (U/min)", "speed", "rpm"),
        ("target_rpm", "set_speed", "rpm"),
        ("setpoint_rad_s", "set_speed", "rad/s"),
        ("control_V", "command", "V"),
        ("left_rpm", "speed", "rpm"),
        ("m1setvel", "set_speed", ""),
        ("batteryVoltage", "supply_voltage", ""),
        ("U_soll", "terminal_voltage", ""),
        ("Commanded_PWM", "command", ""),
        ("encoder", "position", "counts"),
        ("millis", "time", "ms"),
        ("Скорость (об/мин)", "speed", "rpm"),
        ("motor temperature", OTHER, ""),
        ("current_limit", OTHER, ""),
        ("sample", INDEX, ""),
        ("pulses_N", "", ""),
        ("CH1", "", ""),
        ("pos_m", "position", ""),  # of the motor, or metres
    ],
)
def test_a_name_says_quantity_and_unit(name: str, quantity: str, unit: str) -> None:
    found = meaning(Described(name, (name,)))
    assert (found.quantity, found.unit) == (quantity, unit)


@pytest.mark.slow
@given(st.text(max_size=40), st.sampled_from(["", "A", "V", "rpm", "s", "counts"]))
def test_any_name_has_a_meaning(name: str, unit: str) -> None:
    found = meaning(Described(name, (name,), unit))
    assert all(words(name))
    if found.unit and found.quantity not in ("", INDEX, OTHER):
        assert found.unit in allowed(found.quantity)


@pytest.mark.slow
def test_amperes_under_a_header_of_another_unit_are_asked_about(tmp_path: Path) -> None:
    """The worst result is a wrong unit: a header is never overruled, and never trusted blindly."""
    table = columns(time=1.0, voltage=1.0, current=1e3, speed=RPM)
    found = of(tmp_path, "time_s,voltage_V,current_A,speed_rpm", table)
    (question,) = found.questions
    assert {a.known.units["current"] for a in question.answers} == {"A", "mA"}
    settled = of(tmp_path, "time_s,voltage_V,current_A,speed_rpm", table, question.answers[0].known)
    assert not settled.questions


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us")])
def test_a_time_without_a_unit_is_told_by_the_motor(
    scale: float, unit: str, tmp_path: Path
) -> None:
    table = columns(time=scale, voltage=1.0, current=1.0, speed=RPM)
    found = of(tmp_path, "t,u,i,n", table)
    assert not found.questions
    assert units(found)["time"] == unit


def test_milliamperes_without_a_unit_are_told_by_the_motor(tmp_path: Path) -> None:
    found = of(tmp_path, "time,voltage,current", columns(time=1.0, voltage=1.0, current=1e3))
    assert not found.questions
    assert units(found)["current"] == "mA"


def test_a_speed_without_a_unit_is_asked_for(tmp_path: Path) -> None:
    found = of(tmp_path, "time_s,voltage,current,speed", columns(**TUV, speed=RPM))
    (question,) = found.questions
    assert "speed" in question.text
    assert {"rpm"} < {answer.text for answer in question.answers}


def test_the_slope_of_a_position_tells_the_unit_of_a_speed(tmp_path: Path) -> None:
    table = columns(**TUV, speed=1.0, position=1.0)
    found = of(tmp_path, "time_s,u,i,speed,angle_rad", table)
    assert not found.questions
    assert units(found)["speed"] == "rad/s"


@pytest.mark.parametrize("header", ["sample", "time", "", "X"])
def test_a_row_number_is_never_taken_for_seconds(header: str, tmp_path: Path) -> None:
    table = columns(**TUV)
    table[:, 0] = np.arange(len(table))
    found = of(tmp_path, f"{header},voltage (V),current (A)", table)
    assert found.questions
    assert "row" in found.questions[0].text
    stated = found.questions[0].of_number(0.002)
    settled = of(tmp_path, f"{header},voltage (V),current (A)", table, stated)
    assert not settled.questions
    assert "time=row*0.002:s" in settled.maps


def test_columns_without_names_are_told_by_a_motors_laws(tmp_path: Path) -> None:
    table = columns(time=1.0, current=1.0, speed=RPM, voltage=1.0)
    found = of(tmp_path, "", table)
    assert [m.partition(":")[0] for m in found.maps] == [
        "time=column1", "voltage=column4", "current=column2", "speed=column3"
    ]  # fmt: skip
    (question,) = found.questions
    assert "column3" in question.text  # whose unit only a person knows


def test_columns_of_several_motors_are_asked_about(tmp_path: Path) -> None:
    one = columns(time=1.0, current=1.0, speed=1.0)
    table = np.column_stack([one, one[:, 1:]])
    found = of(tmp_path, "t_s,m1_current_A,m1_speed_rpm,m2_current_A,m2_speed_rpm", table)
    (question,) = found.questions
    assert [answer.text[0] for answer in question.answers] == ["1", "2"]
    chosen = of(
        tmp_path, "t_s,m1_current_A,m1_speed_rpm,m2_current_A,m2_speed_rpm", table,
        question.answers[1].known,
    )  # fmt: skip
    assert not chosen.questions
    assert "current=m2_current_A:A" in chosen.maps


@pytest.mark.slow
def test_counts_beside_a_speed_are_left_out_and_alone_are_asked_for(tmp_path: Path) -> None:
    table = columns(**TUV, speed=RPM, position=300.0).round(6)
    found = of(tmp_path, "time_s,u_V,i_A,rpm,encoder", table)
    assert not found.questions
    assert "--counts-per-turn" in found.readings["encoder"]
    alone = of(tmp_path, "time_s,u_V,i_A,encoder", np.delete(table, 3, axis=1))
    (question,) = alone.questions
    assert question.of_number(2000.0) == Known(counts_per_turn=2000.0)
    with pytest.raises(UsageError, match="above zero"):
        question.of_number(0.0)


def test_figures_of_no_motor_are_not_taken_unasked(tmp_path: Path) -> None:
    table = columns(time=1.0, voltage=1e3, current=1e-3, speed=RPM)
    found = of(tmp_path, "time_s,voltage_V,current_A,speed_rpm", table)
    assert found.questions


def test_what_a_person_states_is_kept(tmp_path: Path) -> None:
    table = columns(**TUV, speed=RPM)
    known = of_maps(("speed=speed:rpm", "voltage=u:V"))
    found = of(tmp_path, "time_s,u,i,speed", table, known)
    assert not found.questions
    assert units(found)["speed"] == "rpm"
    with pytest.raises(UsageError, match="is not QUANTITY=COLUMN:UNIT"):
        of_maps(("speed",))


def test_a_table_without_numbers_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("state,mode\n1,4\n2,4\n3,5\n4,7\n", encoding="utf-8")
    with pytest.raises(DataError, match="no column of numbers is a quantity"):
        propose(look(path, TableOptions()), Known())


def test_reversed_columns_are_found_by_the_laws() -> None:
    true = log()
    found = laws.found(true["time"], true["voltage"], -true["current"], true["speed"])
    assert found is not None
    assert found.holds
    assert found.signs == (-1.0, 1.0)
    assert pytest.approx(2.0, rel=0.05) == found.R
    assert pytest.approx(0.05, rel=0.05) == found.K
    assert found.J_over_K == pytest.approx(1e-3, rel=0.05)


def test_a_page_fits_a_terminal_and_its_command_is_whole(tmp_path: Path) -> None:
    head = "time_s,voltage of the motor's terminals (V),current_mA,speed_rpm,state"
    table = np.column_stack([columns(time=1.0, voltage=1.0, current=1e3, speed=RPM), log()["time"]])
    found = of(tmp_path, head, table)
    for plain in (False, True):
        assert max(map(len, page(found, plain=plain).splitlines())) <= WIDTH
    shown = command(
        ["motorid", "import", "a b.csv", *(w for m in found.maps for w in ("--map", m))]
    )
    assert max(map(len, shown.splitlines())) <= WIDTH
    assert shlex.split(shown.replace("\\\n", " "))[3::2] == ["--map"] * len(found.maps)


@pytest.mark.slow
@given(
    st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=300), st.integers(1, 40),
    st.booleans(),
)  # fmt: skip
def test_any_column_has_a_plot(values: list[float], width: int, plain: bool) -> None:
    lines = braille.plot(np.array(values), width, plain=plain)
    assert [len(line) for line in lines] == [width, width]


def test_a_plot_shows_a_step() -> None:
    step = np.r_[np.zeros(8), np.ones(8)]
    assert braille.plot(step, 4) == ["\u2800\u2800\u2809\u2809", "\u28c0\u28c0\u2800\u2800"]
    assert braille.plot(step, 4, plain=True) == ["  **", "**  "]


def test_a_question_shows_its_answers() -> None:
    text = asked(Question("Which?", number="seconds", quantity="time", formula="row*{}", unit="s"))
    assert "a number: seconds" in text


def test_columns_under_each_others_names_can_be_exchanged(tmp_path: Path) -> None:
    head = "time_s,voltage_V,current_A,speed_rpm"
    table = columns(time=1.0, current=1.0, voltage=1.0, speed=RPM)
    (question,) = of(tmp_path, head, table).questions
    _, exchanged = question.answers
    found = of(tmp_path, head, table, exchanged.known)
    assert not found.questions
    assert {"voltage=current_A:V", "current=voltage_V:A"} < set(found.maps)


def test_a_gear_and_another_unit_look_alike_and_are_asked_about(tmp_path: Path) -> None:
    head, table = "time_s,voltage_V,current_A,rpm", columns(**TUV, speed=1.0)  # rad/s
    (question,) = of(tmp_path, head, table).questions
    assert "gear" in question.text
    assert [a.known.units["speed"] for a in question.answers][:2] == ["rpm", "rad/s"]
    assert not of(tmp_path, head, table, Known(geared=True)).questions


def test_a_voltage_that_is_not_the_motors_is_asked_about(tmp_path: Path) -> None:
    table = columns(**TUV, speed=RPM)
    table[:, 1] = 12.0 + 0.02 * np.random.default_rng(1).standard_normal(len(table))
    (question,) = of(tmp_path, "time_s,voltage_V,current_A,rpm", table).questions
    assert "does not follow" in question.text
    assert [a.option for a in question.answers][1] == "--sense supply"
    settled = of(tmp_path, "time_s,voltage_V,current_A,rpm", table, question.answers[1].known)
    assert settled.sense == "supply"
    assert not settled.questions


def test_a_converters_counts_are_taken_for_no_unit(tmp_path: Path) -> None:
    table = columns(time=1e3, voltage=1023 / 30, current=1023 / 20, speed=RPM).round()
    table[:, 2] += 512
    named = of(tmp_path, "t_ms,adc_voltage,adc_current,rpm", table)
    assert {m.partition("=")[0] for m in named.maps} == {"time", "speed"}
    assert "raw counts" in named.readings["adc_current"]
    found = of(tmp_path, "t_ms,voltage,current,rpm", table)
    assert any("current" in q.text for q in found.questions)
    assert any("voltage" in q.text for q in found.questions)


@pytest.mark.slow
def test_rows_without_a_number_are_said_before_the_import(tmp_path: Path) -> None:
    path = write(tmp_path, "time_s,voltage_V,current_A,rpm", columns(**TUV, speed=RPM))
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[50] = lines[50].rpartition(",")[0] + ",n/a"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    found = propose(look(path, TableOptions()), NOTHING)
    assert any("rpm holds no number in 1 rows" in remark for remark in found.remarks)


@pytest.mark.slow
def test_real_logs_are_proposed_right_or_asked_about(shared_data: Path) -> None:
    def at(name: str) -> Proposal:
        return propose(look(shared_data / name, TableOptions()), NOTHING)

    held = at("pwm-rpm/log_20260601161526.csv")
    assert not held.questions
    assert units(held) == {"time": "ms", "speed": "rpm", "command": "1"}
    three = at("robotino/data_for_identification_with_integral.csv")
    assert "3 motors" in three.questions[0].text
    points = at("frc-curves/cim.csv")
    assert "no column is a time" in points.questions[0].text  # Speed rises evenly, and is none
    bench = at("speed-bench/Jan-27-2022--15-53-18.csv")
    (current, speed) = bench.questions
    assert "mA" in {a.known.units["current"] for a in current.answers}
    assert "rad/s" in {a.known.units["speed"] for a in speed.answers}


STEPS = np.column_stack([
    0.02 * np.arange(60.0), np.repeat([1.5, 2.8, 1.5], 20), np.repeat([200.0, 400.0, 201.0], 20)
])  # fmt: skip


def test_an_output_without_a_name_is_asked_about(tmp_path: Path) -> None:
    """t, u, y: --yes imported a voltage alone."""
    found = of(tmp_path, "t,u,y", STEPS)
    (question,) = found.questions
    options = [answer.option for answer in question.answers]
    assert options[:2] == ["--map speed=y:UNIT", "--map position=y:UNIT"]
    said = of(tmp_path, "t,u,y", STEPS, of_maps(("speed=y:deg/s",)))
    assert not said.questions
    assert "voltage=u:V" in said.maps


def test_volts_that_never_change_beside_a_command_are_left_out(tmp_path: Path) -> None:
    table = np.column_stack([STEPS, np.full(60, 11000.0)])
    found = of(tmp_path, "t_s,pwm,rpm,VTarget", table)
    assert found.readings["VTarget"] == "left out: never changes, and pwm does"


@pytest.mark.parametrize(("jitter", "asked_of"), [(0.0, True), (4.0, False)])
def test_steps_of_1000_may_be_of_a_slow_sweep(
    tmp_path: Path, jitter: float, asked_of: bool
) -> None:
    stamps = 84184.0 + 1000.0 * np.arange(60.0) + jitter * (np.arange(60) % 2)
    found = of(tmp_path, "time,pwm,rpm", np.column_stack([stamps, STEPS[:, 1:]]))
    assert any("Unit of time" in q.text for q in found.questions) is asked_of


def test_a_name_behind_the_mark_of_a_comment_is_the_column_s(tmp_path: Path) -> None:
    found = of(tmp_path, "# rpm, pwm, t_s", STEPS[:, ::-1])
    assert "speed=rpm:rpm" in found.maps


def test_a_time_whose_first_stamp_is_stale_is_one(tmp_path: Path) -> None:
    table = STEPS.copy()
    table[0, 0] = 7.4
    assert any(m.startswith("time=t:") for m in of(tmp_path, "t,pwm,rpm", table).maps)


@pytest.mark.parametrize(
    ("most", "share"), [(0.8, "pwm*vbat"), (90.0, "pwm/100*vbat"), (200.0, "pwm/255*vbat")]
)
def test_a_duty_and_a_supply_make_a_voltage(tmp_path: Path, most: float, share: str) -> None:
    table = np.column_stack([STEPS, np.full(60, 11.4) - 0.01 * (np.arange(60) % 3)])
    table[:, 1] *= most / 2.8
    found = of(tmp_path, "t_s,pwm,rpm,vbat", table)
    assert any(f"--map voltage={share}:V makes it" in said for said in found.remarks)
    (whole,) = [m for m in found.maps if m.startswith("supply_voltage")]
    made = of(tmp_path, "t_s,pwm,rpm,vbat", table, of_maps((f"voltage={share}:V", whole)))
    assert not any("makes it" in said for said in made.remarks)


def test_a_command_belongs_to_the_motor_whose_speed_was_chosen(tmp_path: Path) -> None:
    two = np.column_stack([STEPS, STEPS[:, 1:] + 1.0])
    head = "t_s,left_pwm,left_rpm,right_pwm,right_rpm"
    for side in ("left", "right"):
        found = of(tmp_path, head, two, of_maps((f"speed={side}_rpm:rpm",)))
        assert f"command={side}_pwm:1" in found.maps
