"""A motor as an OpenHTF test: every limit of the product is an OpenHTF measurement.

    python docs/examples/openhtf_motor.py D000123

The rig is the simulated one; MOTORID_RIG and MOTORID_PRODUCT name yours. The records go into
the folder of MOTORID_RECORDS, as OpenHTF's own JSON.
"""

import math
import os
import sys

import openhtf as htf
from openhtf.output.callbacks import json_factory

import motorid

PRODUCT = motorid.load_product(os.environ.get("MOTORID_PRODUCT", "sim-disc"))


def measurement(limit):
    """A limit as OpenHTF declares it, without the guard band: that one is motorid's to judge."""
    low = limit.low if math.isfinite(limit.low) else None
    high = limit.high if math.isfinite(limit.high) else None
    declared = htf.Measurement(limit.quantity).in_range(low, high)
    return declared.doc(f"{limit.unit}, rule {limit.rule.name}")


@htf.measures(*(measurement(limit) for limit in PRODUCT.limits.values()))
@htf.measures(htf.Measurement("verdict").equals("PASS"))
def motor(test):
    """Measures the motor and hands every figure over; stops the test where it is INVALID."""
    with motorid.connect(os.environ.get("MOTORID_RIG", "sim-line")) as board:
        capture = board.run(PRODUCT.program, serial=test.test_record.dut_id)
    verdict = motorid.judge(motorid.fit(capture, model="six"), PRODUCT)
    test.measurements.verdict = str(verdict.outcome)
    for name in PRODUCT.limits:
        value = verdict[name].reading.value
        if value is not None:
            test.measurements[name] = value
    for reason in verdict.reasons:
        test.logger.warning(reason)
    return htf.PhaseResult.STOP if verdict.outcome == "INVALID" else htf.PhaseResult.CONTINUE


def main():
    """Runs the test on the motor of the serial number given; true where it passed."""
    test = htf.Test(motor, test_name=PRODUCT.name, test_version="1")
    folder = os.environ.get("MOTORID_RECORDS", ".")
    pattern = os.path.join(folder, "{dut_id}.{start_time_millis}.json")
    test.add_output_callbacks(json_factory.OutputToJSON(pattern, indent=2))
    return test.execute(test_start=lambda: sys.argv[1])


if __name__ == "__main__":
    sys.exit(0 if main() else 1)
