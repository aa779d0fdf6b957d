"""Names of files, records of lines, registers that wrap, an encoder's lines and a PWM's beat."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from motorid.capture.naming import OTHERS, refuse_file_name, refuse_other_format
from motorid.capture.pwm_window import beat_hz, said
from motorid.capture.quadrature import counts, is_pair
from motorid.capture.record_lines import (
    NoRecordError,
    json_record,
    kind_of,
    labelled_record,
    moment,
)
from motorid.capture.wrapped_position import continued
from motorid.errors import DataError, UsageError

NAN = float("nan")


# -- names of files
def test_a_name_of_another_kind_of_file_is_refused() -> None:
    for suffix in (one for suffixes in OTHERS.values() for one in suffixes):
        with pytest.raises(UsageError, match=r"a capture is an HDF5 file.*: name it run\.h5"):
            refuse_other_format(Path(f"a/run{suffix.upper()}"))
        with pytest.raises(UsageError, match=r"says that it is a file: give -o out"):
            refuse_file_name(Path(f"a/out{suffix}"))
    for name in ("run.h5", "M17.2", "run", "run.capture"):
        refuse_other_format(Path(name))
    refuse_file_name(Path("M17.2"))
    with pytest.raises(UsageError, match="says that it is a file"):
        refuse_file_name(Path("out.H5"))


# -- records
def test_a_labelled_line_s_stamp_is_of_the_day() -> None:
    line = "01:02:03.5 -> speed: 12.5\tcurrent=-3e-1 x:inf, n:nan"
    found = labelled_record(line)
    assert found["stamp"] == pytest.approx(3600 + 120 + 3.5)
    assert (found["speed"], found["current"], found["x"]) == (12.5, -0.3, math.inf)
    for wrong in ("01:02:03 -> ", "speed: x", "a:1 a:2", ""):
        with pytest.raises(NoRecordError):
            labelled_record(wrong)


def test_an_object_s_members_are_numbers_or_texts() -> None:
    found = json_record('{"a": true, "b": {"c": 2}, "d": [3, [4]], "e": null, "f": "x"}')
    assert found == {"a": 1.0, "b.c": 2.0, "d[1]": 3.0, "d[2][1]": 4.0, "e": "", "f": "x"}
    for wrong in ("[1]", "3", "{"):
        with pytest.raises(NoRecordError):
            json_record(wrong)


@pytest.mark.parametrize(
    ("good", "bad", "kind"),
    [(8, 0, True), (7, 2, True), (9, 4, False), (10, 3, True), (1, 1, False), (2, 1, True)],
)
def test_most_lines_are_records(good: int, bad: int, kind: bool) -> None:
    lines = [*['{"a": 1}'] * good, *["x y z"] * bad, ""]
    assert kind_of(lines) == ("JSON lines" if kind else None)
    assert kind_of(["a: 1"] * good + ["x y z"] * bad) == ("labelled lines" if kind else None)


def test_moments_keep_every_digit() -> None:
    first = moment("2026-01-31T23:59:59.999999999Z")
    assert first is not None
    later = {
        "2026-02-01T00:00:00.000000001Z": 2e-9,
        "2026-02-01 02:00:00,5+02:00": 0.500000001,
        "2026-02-01": 1e-9,
        "2026-01-31T23:00:00-01:30": 1800.000000001,
    }
    for text, seconds in later.items():
        found = moment(text)
        assert found is not None
        assert found.since(first) == pytest.approx(seconds, abs=1e-12)
    for none in ("2026-01-3", "2026/01/31", "2026-13-01", "1234567890", "2026-01-31T" + "0" * 40):
        assert moment(none) is None


# -- positions
@pytest.mark.parametrize(
    ("changes", "good"),
    [
        ([10.0] * 20, True),
        ([55.0] * 20, False),  # beyond a fifth of the span nothing is a smooth change
        ([0.0] * 3, False),
    ],
)
def test_only_small_changes_between_jumps_are_a_rotor_s(changes: list[float], good: bool) -> None:
    true = np.r_[0.0, np.cumsum(changes * 5)]
    notes: list[str] = []
    found = continued(true % 256.0, 0.0, notes)
    assert np.array_equal(found, true) is (good or not np.any(true >= 256.0))
    assert bool(notes) is good


@pytest.mark.parametrize(("jump", "good"), [(-241.5, True), (-240.5, False)])
def test_a_jump_is_of_a_register_s_size_within_a_change_and_a_half(jump: float, good: bool) -> None:
    before = np.r_[np.arange(0.0, 260.0, 10.0)][:26]  # 0 to 250, by tens: 256 less 15 or more
    values = np.r_[before, before[-1] + jump, before[-1] + jump + 10.0]
    notes: list[str] = []
    found = continued(values, 0.0, notes)
    assert bool(notes) is good
    assert found[-1] == pytest.approx(values[-1] + (256.0 if good else 0.0))


# -- an encoder's lines, and a PWM's beat
def test_edges_go_up_where_the_first_line_leads() -> None:
    a, b = np.array([0, 1, 1, 0, 0.0]), np.array([0, 0, 1, 1, 0.0])
    assert counts(a, b).tolist() == [0, 1, 2, 3, 4]
    assert counts(b, a).tolist() == [0, -1, -2, -3, -4]
    assert is_pair(a, b, 4)
    assert not is_pair(a, b, 5)
    assert not is_pair(a, 2 * b, 1)
    assert not is_pair(a[:0], b[:0], 0)
    assert np.isnan(counts(np.full(2, NAN), np.full(2, NAN))).all()
    with pytest.raises(DataError, match=r"at once in row 4 \(1 times"):
        counts(np.array([0, NAN, 0, 1, 1.0]), np.array([0, 0, 0, 1, 0.0]))


@pytest.mark.parametrize(
    ("period_s", "beat"),
    [(1e-4, 0.0), (1.00004e-4, 0.0), (1.0009e-4, 17.984), (0.9991e-4, 18.016), (1.0011e-4, None),
     (1e-6, None), (2.0018e-4, 17.984)],
)  # fmt: skip
def test_samples_and_pwm_drift_past_one_another(period_s: float, beat: float | None) -> None:
    found = beat_hz(period_s, 20e3)  # two periods a sample
    assert found == (None if beat is None else pytest.approx(beat, abs=1e-2))


def test_what_a_window_does_in_words() -> None:
    text = said(0.0, 20e3, 3.0, 0.25, 0.0)
    assert "sees an instant of the 20000 Hz PWM, so that 3 V may be read 0.25 V wrong" in text
    assert "the error stays the same from sample to sample" in text
    assert "sees 2.5 periods of" in said(2.5, 20e3, 3.0, 0.25, 4.0)
    assert "comes and goes at 4 Hz" in said(2.5, 20e3, 3.0, 0.25, 4.0)
