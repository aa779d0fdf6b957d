"""A good motor of the simulated line, measured once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

import motorid
from motorid.acquire.record import capture
from motorid.estimate.results.estimate import Estimate
from motorid.quality.product import Product, load_product
from motorid.rig import Rig

Measure = Callable[..., Path]


@pytest.fixture(scope="session")
def product() -> Product:
    return load_product("sim-disc")


@pytest.fixture(scope="session")
def line_rig() -> Rig:
    rig = motorid.load_rig("sim-line")
    return replace(rig, port=f"{rig.port}&speed=max")


@pytest.fixture(scope="session")
def measure(product: Product, line_rig: Rig, tmp_path_factory: pytest.TempPathFactory) -> Measure:
    """Measures a motor with more options of the simulated rig; returns the capture's path."""

    def run(options: str = "", serial: str = "D000001") -> Path:
        rig = replace(line_rig, port=f"{line_rig.port}&{options}" if options else line_rig.port)
        path = tmp_path_factory.mktemp("run") / "capture.h5"
        return capture(rig, product.program, path, serial=serial)

    return run


@pytest.fixture(scope="session")
def good(measure: Measure) -> Path:
    return measure()


@pytest.fixture(scope="session")
def estimate(good: Path) -> Estimate:
    return motorid.fit(good, model="six")  # as a station fits
