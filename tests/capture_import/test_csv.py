"""Text tables of other people: dialects found, units converted, bad cells named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from motorid.capture.csv_reader import CsvSource
from motorid.capture.table import HELD, NOTES, STATIC, read_table
from motorid.capture.table_checks import SENTINELS
from motorid.errors import DataError, MotoridError, UsageError

MAPS = ["time=t:ms", "current=i:mA", "speed=n:rpm"]


def write(folder: Path, text: str, name: str = "log.csv", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


def table(separator: str = ",", decimal: str = ".", rows: int = 60, header: str = "t,i,n") -> str:
    lines = [header.replace(",", separator)] if header else []
    for k in range(rows):
        cells = [f"{2 * k}", f"{100.5 + k % 7}", f"{10.25 * k}"]
        lines.append(separator.join(cell.replace(".", decimal) for cell in cells))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("separator", "decimal"),
    [(",", "."), (";", "."), (";", ","), ("\t", ","), ("|", "."), (" ", ".")],
)
def test_separator_and_decimal_mark_are_found(tmp_path: Path, separator: str, decimal: str) -> None:
    capture = read_table(write(tmp_path, table(separator, decimal)), MAPS)
    assert capture.period_s == pytest.approx(2e-3, rel=1e-9)
    assert capture.channels["current"].values[1] == pytest.approx(0.1015)
    assert capture.channels["speed"].values[4] == pytest.approx(41 * 2 * np.pi / 60)
    assert capture.channels["speed"].unit == "rad/s"


def test_two_rows_are_the_fewest(tmp_path: Path) -> None:
    assert len(read_table(write(tmp_path, table(rows=2)), MAPS)) == 2
    with pytest.raises(DataError, match="1 usable rows there: a capture needs two"):
        read_table(write(tmp_path, table(rows=1)), MAPS)


def test_several_header_lines_with_units_and_trailing_separators(tmp_path: Path) -> None:
    body = "".join(f"{k};{k / 2};\n" for k in range(40))
    path = write(tmp_path, "Time;Motor speed;\nms;rad/s;\nt;w;\n" + body)
    source = CsvSource(path)
    assert source.header_units["t"] == "ms"
    by_short = read_table(path, ["time=t:ms", "speed=w:rad/s"])
    by_long = read_table(path, ["time=Time:ms", "speed=Motor speed:rad/s"])
    assert np.array_equal(by_short.channels["speed"].raw, by_long.channels["speed"].raw)
    assert len(by_short) == 40


def test_header_that_contradicts_the_map_is_said(tmp_path: Path) -> None:
    body = "".join(f"{k};{k / 2}\n" for k in range(40))
    path = write(tmp_path, "t;w\nms;rad/s\n" + body)
    notes = read_table(path, ["time=t:s", "speed=w:rad/s"]).provenance[NOTES]
    assert any("t in ms, the map in s" in note for note in notes)


def test_names_with_brackets_and_arithmetic(tmp_path: Path) -> None:
    body = "".join(f"{k},{2 * k},{k + 1}\n" for k in range(30))
    path = write(tmp_path, "Time(ms),Input Power,Current\n" + body)
    capture = read_table(
        path,
        ["time=Time(ms):ms", "voltage=Input Power/Current:V", "current=-Current*gain+1:A",
         "speed=row:rad/s"],
        constants={"gain": 2.0},
    )  # fmt: skip
    assert capture.channels["terminal_voltage"].values[3] == pytest.approx(6 / 4)
    assert capture.channels["current"].values[3] == pytest.approx(-7.0)
    assert capture.channels["speed"].values[3] == 3


def test_file_without_a_header_has_numbered_columns(tmp_path: Path) -> None:
    path = write(tmp_path, table(header=""))
    capture = read_table(path, ["time=column1:ms", "current=column2:mA"])
    assert capture.channels["current"].values[0] == pytest.approx(0.1005)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_encodings(tmp_path: Path, encoding: str) -> None:
    text = table(header="t,i,n").replace("t,i,n", "t,i,n")
    path = write(tmp_path, text.replace("i,", "i,", 1).replace("\n", "\r\n"), encoding=encoding)
    assert len(read_table(path, MAPS)) == 60


@pytest.mark.parametrize(
    ("line", "cell", "what"),
    [
        (10, "oops", "'oops', not a number"),
        (11, "NaN", "'NaN', not a number"),
        (12, "", "is empty"),
        (13, "inf", "'inf', not a number"),
        (14, "-9999", "looks like a mark for missing"),
    ],
)
def test_bad_cells_are_named_or_dropped(tmp_path: Path, line: int, cell: str, what: str) -> None:
    lines = table().splitlines()
    first, _, last = lines[line - 1].split(",")
    lines[line - 1] = ",".join((first, cell, last))
    if cell == "-9999":  # a sentinel stands far out of its column
        lines = [row.replace("100.5", "0.5").replace("10", "1") if k else row
                 for k, row in enumerate(lines)]  # fmt: skip
        lines = [f"{k},{-9999 if k == line - 1 else k % 5},{k}" if k else row
                 for k, row in enumerate(lines)]  # fmt: skip
    path = write(tmp_path, "\n".join(lines) + "\n")
    with pytest.raises(DataError) as caught:
        read_table(path, MAPS)
    message = str(caught.value)
    assert str(path) in message
    assert f"line {line}" in message
    assert "'i'" in message
    assert what in message
    dropped = read_table(path, MAPS, drop_bad=True)
    assert np.isnan(dropped.channels["current"].values).sum() == 1
    assert np.isfinite(dropped.channels["speed"].values).all()
    assert len(dropped) == len(lines) - 1
    assert any("left out" in note for note in dropped.provenance[NOTES])


def test_repeated_header_is_named(tmp_path: Path) -> None:
    lines = table().splitlines()
    lines.insert(30, "t,i,n")
    with pytest.raises(DataError, match=r"line 31.*'t'"):
        read_table(write(tmp_path, "\n".join(lines)), MAPS)


def test_bad_cells_of_unmapped_columns_do_not_matter(tmp_path: Path) -> None:
    body = "".join(f"{k},{k / 2},{'text' if k % 3 else 1}\n" for k in range(40))
    capture = read_table(write(tmp_path, "t,w,remark\n" + body), ["time=t:s", "speed=w:rad/s"])
    assert len(capture) == 40


def test_ragged_line_is_named(tmp_path: Path) -> None:
    lines = table().splitlines()
    lines[20] += ",7,8,9"
    with pytest.raises(DataError, match="line 21"):
        read_table(write(tmp_path, "\n".join(lines)), MAPS)


def test_time_that_steps_back_is_named_or_dropped(tmp_path: Path) -> None:
    lines = table().splitlines()
    lines[15] = lines[12]
    path = write(tmp_path, "\n".join(lines))
    with pytest.raises(DataError, match="line 16 steps back in time"):
        read_table(path, MAPS)
    assert len(read_table(path, MAPS, drop_bad=True)) == 59


def test_irregular_stamps_are_kept_and_pauses_are_gaps(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    steps = 0.03 + 0.002 * rng.standard_normal(100)
    steps[50] = 0.3
    stamps = np.cumsum(steps)
    body = "".join(f"{t:.6f},{k}\n" for k, t in enumerate(stamps))
    capture = read_table(write(tmp_path, "t,w\n" + body), ["time=t:s", "speed=w:rad/s"])
    assert capture.time_s == pytest.approx(stamps - stamps[0], abs=1e-6)
    assert [gap.index for gap in capture.gaps] == [50]
    assert any("irregular" in note for note in capture.provenance[NOTES])


def test_slow_unit_of_time_is_said(tmp_path: Path) -> None:
    body = "".join(f"{30 * k},{k}\n" for k in range(50))
    capture = read_table(write(tmp_path, "t,w\n" + body), ["time=t:s", "speed=w:rad/s"])
    assert any("usual period is 30 s" in note for note in capture.provenance[NOTES])


def test_counts_held_samples_and_wrong_scale_are_seen(tmp_path: Path) -> None:
    k = np.arange(400)
    angle = 2 * np.pi * 1e-3 * k  # one turn a second at 1 kHz
    speed = np.repeat(60.0 + 5 * np.sin(2 * np.pi * np.arange(80) / 40), 5)  # rpm
    body = "".join(
        f"{i},{round(a / (2 * np.pi) * 1000)},{s:.3f}\n"
        for i, a, s in zip(k, angle, speed, strict=True)
    )
    path = write(tmp_path, "t,q,n\n" + body)
    maps = ["time=t:ms", "position=q:counts", "speed=n:rpm"]
    with pytest.raises(UsageError, match="counts-per-turn"):
        read_table(path, maps)
    right = read_table(path, maps, counts_per_turn=1000)
    assert right.channels["position"].resolution == pytest.approx(2 * np.pi / 1000)
    assert right.provenance[HELD] == {"speed": 5}
    assert not any("derivative" in note for note in right.provenance[NOTES])
    wrong = read_table(path, maps, counts_per_turn=4000)
    assert any("4 times the derivative" in note for note in wrong.provenance[NOTES])


def test_magnitude_of_a_current_is_found(tmp_path: Path) -> None:
    speed = np.repeat([10.0, 0.0, -10.0, 0.0], 25)
    current = np.abs(speed) / 10
    body = "".join(f"{k},{i},{w}\n" for k, (i, w) in enumerate(zip(current, speed, strict=True)))
    path = write(tmp_path, "t,i,w\n" + body)
    capture = read_table(path, ["time=t:ms", "current=i:A", "speed=w:rad/s"])
    assert capture.channels["current"].unsigned
    forward = write(tmp_path, "t,i,w\n" + body.replace("-10", "10"), "forward.csv")
    capture = read_table(forward, ["time=t:ms", "current=i:A", "speed=w:rad/s"])
    assert not capture.channels["current"].unsigned


SIGNED = [0.0] * 10 + [10.0] * 40 + [0.0] * 10 + [-10.0] * 40  # volts


def turning(volts: list[float], tau: float = 8.0) -> list[float]:
    """A speed that follows them, in rows."""
    speed, out = 0.0, []
    for v in volts:
        speed += (5.0 * v - speed) / tau
        out.append(speed)
    return out


@pytest.mark.parametrize(
    ("volts", "magnitude", "unsigned"),
    [
        (SIGNED, True, True),
        (SIGNED, False, False),
        ([0.0] * 10 + [10.0] * 40 + [-10.0] * 50, True, True),  # through zero and up again
        ([0.0] * 10 + [-10.0] * 40 + [10.0] * 50, True, True),  # backward first
        ([0.0] * 10 + [10.0] * 60 + [-10.0] * 5 + [10.0] * 25, True, False),  # braked, not turned
        ([0.0] * 10 + [10.0] * 90, True, False),  # one way
    ],
)
def test_magnitude_of_a_speed_is_found(
    tmp_path: Path, volts: list[float], magnitude: bool, unsigned: bool
) -> None:
    speed = [abs(w) if magnitude else w for w in turning(volts)]
    rows = zip(volts, speed, turning(volts), strict=True)
    body = "".join(f"{k},{v},{(v - w / 5) / 4},{s}\n" for k, (v, s, w) in enumerate(rows))
    path = write(tmp_path, "t,v,i,w\n" + body)
    capture = read_table(path, ["time=t:ms", "voltage=v:V", "current=i:A", "speed=w:rad/s"])
    assert capture.channels["speed"].unsigned is unsigned
    assert not capture.channels["current"].unsigned
    assert any("a magnitude" in note for note in capture.provenance[NOTES]) is unsigned


def test_rows_without_time_are_steady_points(tmp_path: Path) -> None:
    capture = read_table(write(tmp_path, table()), ["current=i:mA", "speed=n:rpm"])
    assert capture.provenance[STATIC] is True
    assert len(capture) == 60


def test_aperture_delay_and_window(tmp_path: Path) -> None:
    path = write(tmp_path, table())
    capture = read_table(
        path, MAPS, aperture={"current": 0.128}, delay={"speed": 0.001}, start_s=0.01, stop_s=0.05
    )
    assert capture.channels["current"].kind == "mean"
    assert capture.channels["current"].aperture_s == 0.128
    assert capture.channels["speed"].delay_s == 0.001
    assert len(capture) == 21


@pytest.mark.parametrize(
    ("maps", "word"),
    [
        (["time=t:ms", "current=i"], "QUANTITY=COLUMN:UNIT"),
        (["time=t:ms", "curent=i:A"], "did you mean 'current'"),
        (["time=t:ms", "current=i:rpm"], "not a unit of current"),
        (["time=t:ms", "current=j:A"], "no column 'j'"),
        (["time=t:ms", "current=i:A", "current=i:mA"], "mapped twice"),
        (["time=t:ms"], "nothing is mapped"),
        (["time=t:ms", "current=__import__('os'):A"], "no column"),
        (["time=t:ms", "current=i**9:A"], "no column"),
        (["time=t:ms", "current=i[0]:A"], "no column"),
    ],
)
def test_wrong_maps_are_usage_errors(tmp_path: Path, maps: list[str], word: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_table(write(tmp_path, table()), maps)
    assert word in str(caught.value)


@pytest.mark.parametrize(
    "content", [b"", b"   \n", b"\x00\x01\x02binary\xff", b"no,numbers\nat,all\n"]
)
def test_no_table_is_one_sentence(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "bad.csv"
    path.write_bytes(content)
    with pytest.raises(DataError) as caught:
        read_table(path, MAPS)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_division_by_zero_is_named(tmp_path: Path) -> None:
    body = "".join(f"{k},{k - 5}\n" for k in range(30))
    with pytest.raises(DataError, match=r"line 7.*not finite"):
        read_table(write(tmp_path, "t,a\n" + body), ["time=t:s", "current=1/a:A"])


@pytest.mark.slow
@given(st.binary(max_size=400))
def test_any_bytes_read_or_are_refused(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    path = tmp_path_factory.mktemp("fuzz") / "x.csv"
    path.write_bytes(data)
    try:
        ticks, message = read_table(path, ["time=column1:s", "current=column2:A"]).ticks, ""
    except MotoridError as error:
        ticks, message = np.arange(2), str(error)
    assert np.all(np.diff(ticks) > 0)
    assert "\n" not in message


@pytest.mark.slow
@given(
    st.lists(st.floats(-1e6, 1e6, allow_subnormal=False), min_size=2, max_size=30),
    st.sampled_from([",", ";", "\t"]),
)
def test_numbers_survive(
    tmp_path_factory: pytest.TempPathFactory, numbers: list[float], separator: str
) -> None:
    assume(sum(value not in SENTINELS for value in numbers) >= 2)  # fewer are no capture
    path = tmp_path_factory.mktemp("numbers") / "x.csv"
    rows = [f"{k}{separator}{value!r}" for k, value in enumerate(numbers)]
    path.write_text("\n".join([f"t{separator}x", *rows]))
    marks = any(value in SENTINELS for value in numbers)
    capture = read_table(path, ["time=t:s", "current=x:A"], drop_bad=marks)
    assert marks or np.array_equal(capture.channels["current"].raw, numbers)


def test_an_instruments_uncertainty_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t,i\n" + "\n".join(f"{k},{k % 3}" for k in range(20)), encoding="utf-8")
    maps = ["time=t:ms", "current=i:mA"]
    options = {"gain_uncertainty": {"current": 0.005}, "offset_uncertainty": {"current": 0.01}}
    channel = read_table(path, maps, **options).channels["current"]
    assert channel.gain_uncertainty == 0.005
    assert channel.offset_uncertainty == 0.01
    with pytest.raises(UsageError, match="--gain-uncertainty speed: no such map"):
        read_table(path, maps, gain_uncertainty={"speed": 0.1})


def test_a_column_without_a_number_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path, "t,i,u\n0,1,*2\n0.01,3,\n0.02,4,x\n")
    with pytest.raises(DataError, match="no usable row holds a number for terminal_voltage"):
        read_table(path, ["time=t:s", "current=i:A", "voltage=u:V"], drop_bad=True)


def test_the_ends_of_a_converter_are_readings_unless_told(tmp_path: Path) -> None:
    body = "".join(f"{k},{65535 if k % 10 == 9 else k % 3},{k}\n" for k in range(40))
    path = write(tmp_path, "t,i,n\n" + body)
    kept = read_table(path, MAPS)
    assert np.nanmax(kept.channels["current"].raw) == 65535
    told = read_table(path, MAPS, missing=[65535.0])
    assert np.isnan(told.channels["current"].raw).sum() == 4
    assert np.isfinite(told.channels["speed"].raw).all()
    assert any("4 readings of i left out, as told (65535)" in n for n in told.provenance[NOTES])


def test_what_is_told_to_be_missing_is_no_bad_cell(tmp_path: Path) -> None:
    body = "".join(f"{k},{-999 if k == 9 else k % 3},{k}\n" for k in range(40))
    path = write(tmp_path, "t,i,n\n" + body)
    with pytest.raises(DataError, match="looks like a mark for missing"):
        read_table(path, MAPS)
    assert np.isnan(read_table(path, MAPS, missing=[-999.0]).channels["current"].raw[9])
    maps = [*MAPS[:2], "speed=n/(n-5):rpm"]
    with pytest.raises(DataError, match=r"line 7: speed = n/\(n-5\) is not finite"):
        read_table(path, maps, missing=[-999.0])


def test_a_column_without_a_name_whose_number_names_another_can_still_be_read(
    tmp_path: Path,
) -> None:
    """A header that calls its second column column3."""
    path = tmp_path / "log.csv"
    path.write_text("time,column3,,\n0,1,2,3\n0.1,4,5,6\n0.2,7,8,9\n", encoding="utf-8")
    source = CsvSource(path)
    names = [one.name for one in source.described]
    assert names == ["time", "column3", "column3 without a name", "column4"]
    read = source.read(names)
    assert [float(read.values[name][1]) for name in names] == [0.1, 4.0, 5.0, 6.0]
