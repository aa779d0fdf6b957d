"""A capture as a table: each value comes back, and what is missing stays missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat

from motorid.capture import store, table
from motorid.capture.model import CURRENT, Gap
from motorid.cli import main
from motorid.export.readings import FORMS, columns
from tests.exact_capture import FAULHABER, Plan, clean_capture


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = clean_capture(FAULHABER, Plan(count=200))
    raw = made.channels[CURRENT].raw.copy()
    raw[7] = np.nan
    channels = {**made.channels, CURRENT: replace(made.channels[CURRENT], raw=raw)}
    path = tmp_path_factory.mktemp("readings") / "run.h5"
    gaps = (Gap(index=5, samples=3, reason="lost"),)
    store.save(replace(made, channels=channels, gaps=gaps), path)
    return path


READ = {
    "csv": lambda path: pd.read_csv(path),
    "parquet": pd.read_parquet,
    "mat": lambda path: pd.DataFrame(
        {name: one.ravel() for name, one in loadmat(path).items() if name[0] != "_"}
    ),
}


@pytest.mark.parametrize("to", FORMS)
def test_every_reading_comes_back(
    to: str, capture: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / f"run.{to}"
    assert main.run(["export", str(capture), "--to", to, "-o", str(out)]) == 0
    assert "3 lost samples" in capsys.readouterr().err
    found, wanted = READ[to](out), columns(store.load(capture))
    assert sorted(found.columns) == sorted(wanted)
    assert {"time_s", "current_a", "position_rad", "terminal_voltage_v"} == set(wanted)
    for name, column in wanted.items():
        np.testing.assert_array_equal(found[name].to_numpy(), column)
    assert np.isnan(wanted["current_a"][7])


@pytest.mark.slow
@pytest.mark.parametrize("to", ["csv", "mat"])
def test_an_import_takes_it_back(to: str, capture: Path, tmp_path: Path) -> None:
    out = tmp_path / f"run.{to}"
    assert main.run(["export", str(capture), "--to", to, "-o", str(out)]) == 0
    maps = ["time=time_s:s", "current=current_a:A", "position=position_rad:rad"]
    again = table.read_table(out, maps, drop_bad=True)
    np.testing.assert_array_equal(
        again.channels[CURRENT].values, store.load(capture).channels[CURRENT].values
    )


@pytest.mark.parametrize(
    ("options", "code"),
    [(["--to", "csv", "--gear-ratio", "2"], 2), (["--to", "mat"], 2), (["--to", "mujoco"], 4)],
)
def test_what_a_capture_cannot_be(options: list[str], code: int, capture: Path) -> None:
    assert main.run(["export", str(capture), *options]) == code
