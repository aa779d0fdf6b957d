"""A motor as a pytest: one measurement, one test for each limit of the product.

    MOTORID_SERIAL=D000123 pytest docs/examples/pytest_motor.py

The rig is the simulated one; MOTORID_RIG and MOTORID_PRODUCT name yours.
"""

import os

import pytest

import motorid

PRODUCT = motorid.load_product(os.environ.get("MOTORID_PRODUCT", "sim-disc"))


@pytest.fixture(scope="session")
def verdict():
    """The motor in the rig, measured and judged once."""
    serial = os.environ.get("MOTORID_SERIAL", "D000000")
    with motorid.connect(os.environ.get("MOTORID_RIG", "sim-line")) as board:
        capture = board.run(PRODUCT.program, serial=serial)
    return motorid.judge(motorid.fit(capture, model="six"), PRODUCT)


@pytest.mark.parametrize("quantity", PRODUCT.limits)
def test_limit(verdict, quantity):
    measurement = verdict[quantity]
    assert measurement.outcome == "PASS", measurement.reason


def test_whole(verdict):
    assert verdict.outcome == "PASS", "; ".join(verdict.reasons)
