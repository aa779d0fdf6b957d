"""Files that other libraries write."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import scipy.io

from tests.capture_import.corpus.bench_log import columns, log

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


def mat_73(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("bench")
        for name, column in frame().items():
            group[name] = np.asarray(column)[None, :]
            group[name].attrs["MATLAB_class"] = np.bytes_("double")


def parquet_moments(path: Path) -> None:
    table = frame()
    stamps = pd.Timestamp("2026-11-02T10:41:12Z") + pd.to_timedelta(log()["time"], unit="s")
    table.insert(0, "timestamp", stamps)
    table.drop(columns="time_s").to_parquet(path)
