"""The file of a bench's instruments: what it says, what holds where it is silent, what is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from motorid.acquire.scpi.bench_file import BenchFile, parse
from motorid.errors import RigError

BENCH = '[supply]\nresource = "S"\n'


def bench(text: str) -> BenchFile:
    return parse(text, Path("/bench/smu.toml"))


def test_a_bench_of_a_supply_alone() -> None:
    found = bench(BENCH)
    assert (found.visa, found.channel, found.quadrants) == ("@py", "1", 1)
    assert (found.lead_s, found.clock_uncertainty, found.recorder) == (0.1, 5e-5, None)
    assert (found.supply.resource, found.supply.timeout_s) == ("S", 5.0)
    assert (found.supply_dialect.name, found.path, found.text) != ("", "", "")
    assert [one.name for one in found.channels] == ["current", "terminal_voltage"]
    (current, _) = found.channels
    assert (current.instrument, current.query, current.place) == ("supply", "", 0)
    assert (current.scale, current.zero, current.sense, current.facts) == (1.0, 0.0, "bridge", {})


def test_a_bench_of_meters() -> None:
    found = bench(
        'visa = "sim.yaml@sim"\n[supply]\nresource = "S"\nchannel = "2"\nquadrants = 4\n'
        'timeout_s = 9\n[meters.dmm]\nresource = "M"\nerror = ""\n'
        "[channels.current]\n[channels.terminal_voltage]\nsense = 'terminals'\n"
        '[channels.speed]\ninstrument = "dmm"\nquery = "W?"\nfield = 3\nscale = -2\nzero = 0.5\n'
        'gain_uncertainty = 0.01\naperture = "1ms"\n'
    )
    assert found.visa == "/bench/sim.yaml@sim"
    assert (found.channel, found.quadrants, found.supply.timeout_s) == ("2", 4, 9.0)
    assert (found.meters["dmm"].resource, found.meters["dmm"].error) == ("M", "")
    _, volts, speed = found.channels
    assert volts.sense == "terminals"
    assert (speed.instrument, speed.query, speed.place) == ("dmm", "W?", 3)
    assert (speed.scale, speed.zero) == (-2.0, 0.5)
    assert speed.options == {"gain_uncertainty": {"speed": 0.01}, "aperture": {"speed": "1ms"}}


CHANNELS = "[channels.current]\n[channels.terminal_voltage]\n"
METER = '[meters.dmm]\nresource = "M"\n'


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", r"\[supply\] is missing"),
        ("[supply]\n", r"supply\.resource is missing"),
        (BENCH + "[meters.dmm]\n", r"meters\.dmm\.resource is missing"),
        (BENCH + "[odd]\n", "odd"),
        (BENCH + "[channels.torque]\n", "torque"),
        (BENCH + "[channels.current]\n", "channels needs current and terminal_voltage"),
        (BENCH + CHANNELS + 'source = "1"\n', r"source needs a \[recorder\]; without one, write"),
        (BENCH + CHANNELS + "scale = 0\n", r"channels\.terminal_voltage\.scale is 0"),
        (BENCH + CHANNELS + 'instrument = "dmm"\n', r"there is no \[meters\.dmm\]"),
        (BENCH + METER + CHANNELS + 'instrument = "dmm"\n', r"query is missing: which query"),
        (BENCH + CHANNELS + "[channels.speed]\n", r"channels\.speed\.query is missing"),
        (BENCH + CHANNELS + "[channels.position]\n", "only a recorder can count an encoder"),
        (BENCH + CHANNELS + 'filter = "20"\n', "filter terminal_voltage=20: is it Hz or seconds"),
        (
            BENCH + '[recorder]\nresource = "R"\ndialect = "keysight-34970a"\n',
            "are missing: what is on",
        ),
    ],
)
def test_a_bench_that_cannot_be(text: str, says: str) -> None:
    with pytest.raises(RigError, match=rf"^/bench/smu\.toml: .*{says}"):
        bench(text)
