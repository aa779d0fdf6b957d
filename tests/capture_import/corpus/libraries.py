"""Files that other libraries write."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import openpyxl
import pandas as pd
import scipy.io

from tests.capture_import.corpus.bench_log import RPM, columns, log

NAMES = ["time_s", "voltage_V", "current_A", "speed_rad_s"]
SI = {"time": 1.0, "voltage": 1.0, "current": 1.0, "speed": 1.0}


def frame() -> pd.DataFrame:
    return pd.DataFrame(columns(**SI), columns=NAMES)


def pandas_index(path: Path) -> None:
    frame().to_csv(path)


def numpy_text(path: Path) -> None:
    np.savetxt(path, columns(**SI), header="t[s] u[V] i[A] w[rad/s]")


def pandas_json(path: Path) -> None:
    frame().to_json(path, orient="records", lines=True)


def parquet(path: Path) -> None:
    frame().to_parquet(path)


def npz(path: Path) -> None:
    table = {f"{name}": column for name, column in frame().items()}
    np.savez(path, **table)


def mat_5(path: Path) -> None:
    table = {name.replace("speed_rad_s", "omega_rad_s"): c for name, c in frame().items()}
    scipy.io.savemat(path, {"log": {name: np.asarray(c)[:, None] for name, c in table.items()}})


def mat_timeseries(path: Path) -> None:
    """Each signal as a struct with its own Time and Data, as timeseries are exported."""
    table = {"motor_current_A": "current", "motor_voltage_V": "voltage", "omega_rad_s": "speed"}
    stamps = log()["time"][:, None]
    scipy.io.savemat(
        path,
        {"out": {name: {"Time": stamps, "Data": log()[q][:, None]} for name, q in table.items()}},
    )


def mat_73(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("bench")
        for name, column in frame().items():
            group[name] = np.asarray(column)[None, :]
            group[name].attrs["MATLAB_class"] = np.bytes_("double")


def spreadsheet(path: Path) -> None:
    """A title, a blank row, names and units above the readings; a second sheet of notes."""
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.title = "Messung"
    sheet.append(["Motor SN 17, 2. November"])
    sheet.append([])
    sheet.append(["Zeit", "Spannung", "Strom", "Drehzahl"])
    sheet.append(["ms", "V", "A", "1/min"])
    for row in columns(time=1e3, voltage=1.0, current=1.0, speed=RPM):
        sheet.append([float(cell) for cell in row])
    book.create_sheet("Notizen").append(["Lager läuft rau"])
    book.save(path)


def spreadsheet_moments(path: Path) -> None:
    """As pandas writes it, an index in front and stamps as dates."""
    table = frame()
    stamps = pd.Timestamp("2026-11-02T10:41:12") + pd.to_timedelta(log()["time"], unit="s")
    table["time_s"] = stamps.round("ms")
    table.rename(columns={"time_s": "timestamp"}).to_excel(path)


def parquet_moments(path: Path) -> None:
    table = frame()
    stamps = pd.Timestamp("2026-11-02T10:41:12Z") + pd.to_timedelta(log()["time"], unit="s")
    table.insert(0, "timestamp", stamps)
    table.drop(columns="time_s").to_parquet(path)
