"""What a person states of an imported channel, and that nobody stating it is no zero."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.foreign.cases import CASES, MAPS, Case, logs
from motorid.capture import declared, store
from motorid.capture.declared import Aperture, LowPass
from motorid.capture.model import BUTTERWORTH, CURRENT, FACTS, SPEED, Capture, Channel
from motorid.capture.table import read_table
from motorid.errors import UsageError
from tests.six_parameters import fit

OLD = Path(__file__).resolve().parent.parent / "corpus" / "format_1_1"
COLUMNS = ("time=t:s", "current=i:A", "speed=n:rad/s")


def imported(folder: Path, **options: Any) -> Capture:
    path = folder / "log.csv"
    rows = (f"{k / 100:.2f},{0.5 + 0.01 * math.sin(k):.5f},{1.5 * k:g}\n" for k in range(60))
    path.write_text("t,i,n\n" + "".join(rows), encoding="utf-8")
    return read_table(path, COLUMNS, **options)


def test_what_nobody_states_is_not_stated(tmp_path: Path) -> None:
    capture = imported(tmp_path)
    assert all(channel.undeclared == FACTS for channel in capture.channels.values())


@pytest.mark.parametrize(
    ("option", "said", "fact"),
    [
        ("gain_uncertainty", 0.0, "gain"),
        ("offset_uncertainty", 0.0, "offset"),
        ("delay", "0", "delay"),
        ("filter", "0", "filter"),
        ("aperture", "instant", "aperture"),
    ],
)
def test_a_stated_zero_is_stated(tmp_path: Path, option: str, said: Any, fact: Any) -> None:
    capture = imported(tmp_path, **{option: {"current": said}})
    assert capture.channels[CURRENT].undeclared == tuple(f for f in FACTS if f != fact)
    assert capture.channels[CURRENT].states(fact)
    assert not capture.channels[SPEED].states(fact)


def test_counts_have_the_gain_that_counts_per_turn_states(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,x\n" + "".join(f"{k},{3 * k}\n" for k in range(40)), encoding="utf-8")
    counted = read_table(path, ["time=t:ms", "position=x:counts"], counts_per_turn=400.0)
    assert counted.channels["position"].states("gain")
    assert not read_table(path, ["time=t:ms", "position=x:deg"]).channels["position"].states("gain")


def test_a_channel_of_a_board_states_all() -> None:
    assert Channel("current", "A", np.zeros(3)).undeclared == ()


@pytest.mark.slow
def test_a_file_keeps_it(tmp_path: Path) -> None:
    stated = {"current": "20Hz,2", "speed": "8ms"}
    capture = imported(tmp_path, filter=stated, delay={"speed": -0.5e-3})
    store.save(capture, tmp_path / "own.h5")
    (tmp_path / "foreign.h5").write_bytes((tmp_path / "own.h5").read_bytes() + b"\0")  # by a child
    for name in ("own.h5", "foreign.h5"):
        read = store.load(tmp_path / name)
        for channel in capture.channels.values():
            for field in fields(Channel):
                if field.name != "raw":
                    was = getattr(channel, field.name)
                    assert getattr(read.channels[channel.name], field.name) == was, field.name
    assert capture.provenance["declared"]["filter"] == stated


def test_an_import_of_an_older_format_states_what_is_not_zero() -> None:
    channels = store.load(OLD / "imported.h5").channels
    assert channels[CURRENT].undeclared == ("offset", "delay", "filter", "aperture")
    assert channels[SPEED].undeclared == ("gain", "offset", "filter")


def test_the_rest_of_a_chain_is_stated_by_options(tmp_path: Path) -> None:
    capture = imported(
        tmp_path, nonlinearity={CURRENT: "0.003, s, 20"}, reference_drift="0.001,500ms"
    )
    current = capture.channels[CURRENT]
    known = current.nonlinearity, current.nonlinearity_shape, current.full_scale
    assert known == (0.003, "s", 20.0)
    assert (capture.wiring.reference_drift, capture.wiring.reference_time_s) == (0.001, 0.5)
    assert capture.provenance["declared"]["nonlinearity"] == {CURRENT: "0.003, s, 20"}
    silent = imported(tmp_path)
    assert silent.channels[CURRENT].nonlinearity_shape is silent.wiring.reference_drift is None


@pytest.mark.parametrize(
    ("option", "said", "says"),
    [
        ("nonlinearity", {"current": "0.003"}, "its course (bow, cubic, s) and the full scale"),
        ("nonlinearity", {"current": "0.3%,s,20"}, "its course (bow, cubic, s)"),
        ("nonlinearity", {"current": "0.003,z,20"}, "its course (bow, cubic, s)"),
        ("nonlinearity", {"current": "0.003,s,0"}, "its course (bow, cubic, s)"),
        ("nonlinearity", {"current": "0.003,s,20,1"}, "its course (bow, cubic, s)"),
        ("nonlinearity", {"speed": "0.003,s,20"}, "only the current's sensor"),
        ("nonlinearity", {"voltage": "0.003,s,20"}, "no such map"),
        ("reference_drift", "0.001", "such as --reference-drift 0.001,2s"),
        ("reference_drift", "0.1%,2s", "give a share and a time"),
        ("reference_drift", "0.001,0s", "give a share and a time"),
        ("reference_drift", "0.001,2parsec", "is not a unit"),
        ("eccentricity", 0.002, "no angle is mapped"),
    ],
)
def test_a_mistake_in_it_costs_one_sentence(
    tmp_path: Path, option: str, said: Any, says: str
) -> None:
    with pytest.raises(UsageError) as caught:
        imported(tmp_path, **{option: said})
    assert says in str(caught.value)
    assert option.replace("_", "-") in str(caught.value)


def test_an_encoder_s_eccentricity_is_of_an_angle(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,x\n" + "".join(f"{k},{3 * k}\n" for k in range(40)), encoding="utf-8")
    found = read_table(path, ["time=t:ms", "position=x:deg"], eccentricity=0.002)
    assert found.wiring.encoder_eccentricity_rad == 0.002
    with pytest.raises(UsageError, match="no angle is mapped"):
        read_table(path, ["time=t:ms", "position=x:mm"], eccentricity=0.002)


# -- the texts
@pytest.mark.parametrize(
    ("said", "found"),
    [
        ("20Hz", LowPass(1 / (40 * math.pi))),
        ("0.02kHz,1", LowPass(1 / (40 * math.pi))),
        ("20Hz,2", LowPass(1 / (40 * math.pi), 2, BUTTERWORTH)),
        ("8ms", LowPass(8e-3)),
        ("8000 us, 2", LowPass(8e-3, 2)),
        (0.008, LowPass(8e-3)),
    ],
)
def test_a_low_pass_is_a_cut_off_or_a_time_constant(said: str | float, found: LowPass) -> None:
    read = declared.low_pass("current", said)
    assert read.time_s == pytest.approx(found.time_s, rel=1e-12)
    assert (read.order, read.damping) == (found.order, found.damping)


@pytest.mark.parametrize("damping", [1.0, BUTTERWORTH])
def test_what_a_filter_delays_is_the_slope_of_its_phase(damping: float) -> None:
    channel = Channel(
        "current", "A", np.zeros(0), filter_s=3e-3, filter_order=2, filter_damping=damping
    )
    w = 1e-3  # rad/s, slow
    s = 1j * w * channel.filter_s
    phase = np.angle(1.0 / (1.0 + 2.0 * damping * s + s**2))
    assert channel.filter_delay_s == pytest.approx(-phase / w, rel=1e-6)


@pytest.mark.parametrize(
    ("said", "found"),
    [
        ("128ms", Aperture(0.128)),
        ("128 ms, around", Aperture(0.128, "around")),
        ("0.128,after", Aperture(0.128, "after")),
        ("instant", Aperture(0.0)),
        (0.128, Aperture(0.128)),
    ],
)
def test_an_aperture_has_a_place(said: str | float, found: Aperture) -> None:
    assert declared.aperture("current", said) == found


@pytest.mark.parametrize(
    ("option", "said", "told"),
    [
        ("filter", "20", "is it Hz or seconds"),
        ("filter", "20Hz,3", "no order of a filter"),
        ("filter", "20Hz,", "no order of a filter"),
        ("filter", "0Hz", "above 0 Hz"),
        ("filter", "-8ms", "0 or more"),
        ("filter", "20hz", "not a unit"),
        ("filter", "1e-12Hz", "no capture is so long"),
        ("filter", "nanHz", "give a number"),
        ("delay", "1min", "not a unit"),
        ("delay", "1e99", "no capture is so long"),
        ("delay", "soon", "give a number"),
        ("delay_uncertainty", "-1ms", "0 or more"),
        ("aperture", "1ms,arround", "did you mean 'around'"),
        ("aperture", "instant,after", "give a number"),
        ("aperture", "-1ms", "0 or more"),
    ],
)
def test_what_is_none_is_said(tmp_path: Path, option: str, said: str, told: str) -> None:
    with pytest.raises(UsageError, match=told) as caught:
        imported(tmp_path, **{option: {"current": said}})
    assert f"--{option.replace('_', '-')} current={said}" in str(caught.value)


@pytest.mark.parametrize("option", ["delay", "filter", "aperture", "delay_uncertainty"])
def test_a_quantity_that_is_not_mapped_is_said(tmp_path: Path, option: str) -> None:
    with pytest.raises(UsageError, match="no such map, did you mean 'current'"):
        imported(tmp_path, **{option: {"curent": "1ms"}})


NUMBERS = st.floats(-1e7, 1e7).map(repr) | st.sampled_from(
    ["", "1e", "--1", "1e400", "½", "٣", "-0"]
)
UNITS = st.sampled_from(["", "s", "ms", "us", "µs", "ns", "Hz", "kHz", "MHz", "min", "%", "ſ"])
BEHIND = st.sampled_from(["", ",1", ",2", ",3", ",", ",around", ",after", ",before", ",1,2"])
TEXTS = st.builds("{}{}{}".format, NUMBERS, UNITS, BEHIND) | st.text(max_size=12)


@pytest.mark.slow
@given(TEXTS)
def test_any_text_is_read_or_refused_in_one_sentence(said: str) -> None:
    for read in (declared.low_pass, declared.aperture):
        try:
            found = read("current", said)
        except UsageError:
            continue
        size = found.time_s if isinstance(found, LowPass) else found.seconds
        assert 0.0 <= size <= declared.LONGEST_S
    try:
        late = declared.duration("--delay", "current", said, negative=True)
    except UsageError:
        return
    assert abs(late) <= declared.LONGEST_S


@pytest.mark.slow
@given(st.floats(1e-9, 1e5), st.sampled_from(["s", "ms", "us", "ns"]), st.booleans())
def test_a_duration_written_in_any_unit_is_the_same(size: float, unit: str, early: bool) -> None:
    scale = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[unit]
    sign = "-" if early else ""
    read = declared.duration("--delay", "current", f"{sign}{size * scale!r}{unit}", negative=True)
    assert abs(read) == pytest.approx(size, rel=1e-12)
    assert (read < 0) == early


# -- readings that show what comes after their stamp
@pytest.mark.slow
@given(st.floats(-0.1, 0.1), st.floats(-0.1, 0.1), st.floats(0.0, 0.05))
def test_no_stored_reading_is_early_and_none_moves_against_another(
    current: float, speed: float, filter_s: float
) -> None:
    blank = np.zeros(0)
    given_ = {
        CURRENT: Channel(CURRENT, "A", blank, delay_s=current + filter_s, filter_s=filter_s),
        SPEED: Channel(SPEED, "rad/s", blank, delay_s=speed),
    }
    moved = declared.without_early_readings(given_)
    assert all(c.delay_s >= c.filter_delay_s - 1e-15 for c in moved.values())
    apart = moved[CURRENT].delay_s - moved[SPEED].delay_s
    assert apart == pytest.approx(given_[CURRENT].delay_s - given_[SPEED].delay_s, abs=1e-12)


def log(case: Case, folder: Path, early: int, **options: Any) -> Capture:
    """A log whose current was stamped ``early`` rows before what it shows."""
    text = next(iter(logs(case, 0))).splitlines()
    head, rows = text[0].split(","), np.array([line.split(",") for line in text[1:]], dtype=float)
    rows = rows[rows[:, 0] > 0.45]  # it begins amid the motion
    at = head.index("i")
    shown = rows[: len(rows) - early].copy()
    shown[:, at] = rows[early:, at]
    path = folder / "log.csv"
    lines = (",".join(f"{x:.9g}" for x in row) for row in shown)
    path.write_text("\n".join([text[0], *lines]) + "\n", encoding="utf-8")
    return read_table(path, ["time=t:s", *(MAPS[c] for c in case.columns)], **options)


@pytest.mark.slow
def test_a_negative_delay_puts_an_early_stamp_right(tmp_path: Path) -> None:
    case = next(case for case in CASES if case.name == "steps, regular stamps")
    right = fit([log(case, tmp_path, 0)]).parameters
    stated = fit([log(case, tmp_path, 5, delay={"current": "-5ms"})]).parameters
    for name, parameter in right.items():
        value, total = parameter.value, parameter.total
        assert value is not None
        assert total is not None
        assert stated[name].value == pytest.approx(value, abs=total), name
