"""The corpus: each file with its maker, and which of them leave something open."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from motorid.workflow.proposal.question import NOTHING, Known
from tests.capture_import.corpus import instruments, libraries, people, recordings

Maker = Callable[[Path], None]


@dataclass(frozen=True)
class File:
    """``asks``: the file leaves something open, so that no proposal is taken unasked.

    ``quantities`` that it holds at least; ``known``: what no file says, such as counts per turn.
    """

    name: str
    make: Maker
    asks: bool = False
    quantities: frozenset[str] = frozenset({"voltage", "current"})
    known: Known = NOTHING


FULL = frozenset({"voltage", "current", "speed"})
FILES = (
    File("rigol_old.csv", instruments.rigol_old),
    File("rigol_new.csv", instruments.rigol_new),
    File("tektronix.csv", instruments.tektronix),
    File("keysight.csv", instruments.keysight),
    File("siglent.csv", instruments.siglent),
    File("picoscope.csv", instruments.picoscope),
    File("saleae.csv", instruments.saleae),
    File("hantek.csv", instruments.hantek, asks=True),
    File("labview.lvm", instruments.labview),
    File(
        "logic.csv",
        instruments.logic_analyser,
        quantities=frozenset({"position"}),
        known=Known(counts_per_turn=instruments.COUNTS),
    ),
    File("counter.csv", instruments.excel_rounded_stamps),
    File("german.csv", people.german),
    File("french.csv", people.french),
    File("spanish.csv", people.spanish),
    File("portuguese.tsv", people.portuguese),
    File("chinese.csv", people.chinese),
    File("russian.csv", people.russian),
    File("no_units.csv", people.no_units),
    File("millis.csv", people.millis),
    File("reversed.csv", people.reversed_current),
    File("angle.csv", people.angle_and_speed, quantities=FULL | {"position"}),
    File("only_speed.csv", people.only_speed, quantities=frozenset({"speed", "command"})),
    File("plotter.txt", people.plotter),
    File("iso.csv", people.iso_times),
    File("nested.jsonl", people.nested_json),
    File("row_numbers.csv", people.row_numbers, asks=True),
    File("rate.csv", people.rate_in_header),
    File("swapped.csv", people.swapped_names, asks=True),
    File("pandas.csv", libraries.pandas_index),
    File("numpy.txt", libraries.numpy_text),
    File("pandas.jsonl", libraries.pandas_json),
    File("frame.parquet", libraries.parquet),
    File("moments.parquet", libraries.parquet_moments),
    File("sheet.xlsx", libraries.spreadsheet),
    File("moments.xlsx", libraries.spreadsheet_moments),
    File("bench.tdms", recordings.tdms),
    File("bench.mf4", recordings.mdf, quantities=FULL),
    File("json.mcap", recordings.mcap_json, quantities=FULL),
    File("ros2.mcap", recordings.ros_2, quantities=FULL | {"position"}),
    File("robot.wpilog", recordings.wpilog, quantities=FULL),
    File("arrays.npz", libraries.npz),
    File("struct.mat", libraries.mat_5),
    File("timeseries.mat", libraries.mat_timeseries),
    File("v73.mat", libraries.mat_73),
)
