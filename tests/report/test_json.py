"""The JSON of an estimate: strict, and by its published schema."""

from __future__ import annotations

import copy
import dataclasses
import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from motorid.estimate.assembly.doubt import settled
from motorid.estimate.assembly.refusal import refused
from motorid.estimate.model.unexplained import Unexplained
from motorid.estimate.results.estimate import PARAMETERS, Diagnostic, Estimate, Suspect
from motorid.report import json_
from tests.report.example import estimate, parameter, partial

VALIDATOR = jsonschema.Draft202012Validator(json_.schema())


def test_the_schema_is_one() -> None:
    jsonschema.Draft202012Validator.check_schema(json_.schema())


@pytest.mark.parametrize("made", [estimate(), partial()], ids=["whole", "partial"])
def test_the_estimate_follows_the_schema_as_strict_json(made: Estimate) -> None:
    text = json_.dumps(made)
    read = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    VALIDATOR.validate(read)
    assert read == json_.to_dict(made)
    assert list(read["parameters"]) == list(PARAMETERS)


def test_values_are_si_and_intervals_are_from_the_total() -> None:
    made = estimate()
    read = json_.to_dict(made)["parameters"]["K"]
    assert read["value"] == made.parameters["K"].value
    assert read["unit"] == "N·m/A"
    assert read["status"] == "estimated"
    half = (read["interval_95"][1] - read["interval_95"][0]) / 2
    assert math.isclose(half, 1.96 * read["uncertainty"]["total"])
    assert set(read["uncertainty"]) == {"statistical", "instrument", "total"}


def test_the_unknown_is_null() -> None:
    read = json_.to_dict(partial())["parameters"]["R"]
    assert read["value"] is None
    assert read["interval_95"] is None
    assert read["status"] == "not_identifiable"
    assert "terminal voltage" in read["note"]


def test_numpy_nan_and_infinity_become_plain() -> None:
    options = {"fix": {"K": np.float64(0.05)}, "n": np.int64(3), "bad": float("nan"), "t": (1, 2)}
    p = dataclasses.replace(parameter("x", "A", 1.0), total=math.inf, interval_95=(0.0, math.inf))
    made = estimate(options=options, nuisance={"x": p}, chi_square=math.nan)
    read = json.loads(json_.dumps(made))
    VALIDATOR.validate(read)
    assert read["options"] == {"fix": {"K": 0.05}, "n": 3, "bad": None, "t": [1, 2]}
    assert read["nuisance"]["x"]["interval_95"] == [0.0, None]
    assert read["models"][0]["chi_square"] is None


@pytest.mark.parametrize(
    ("path", "wrong"),
    [
        (("parameters", "R", "status"), "guessed"),
        (("parameters", "R", "unit"), "mohm"),
        (("parameters", "R", "value"), None),
        (("parameters", "K", "uncertainty"), {"total": 1.0}),
        (("parameters", "L", "interval_95"), [1.0]),
        (("inputs", 0, "sha256"), "abc"),
        (("diagnostics", 0, "severity"), "fatal"),
        (("schema",), "motorid-estimate-3"),
    ],
)
def test_the_schema_refuses_what_is_wrong(path: tuple[str | int, ...], wrong: object) -> None:
    read = copy.deepcopy(json_.to_dict(estimate()))
    target = read
    for key in path[:-1]:
        target = target[key]
    target[path[-1]] = wrong
    assert not VALIDATOR.is_valid(read)


def test_an_estimate_of_major_1_fits_the_schema() -> None:
    """With its values, whichever of both wrote them."""
    old = Path(__file__).resolve().parent.parent / "corpus" / "format_1_0" / "estimate.json"
    document = json.loads(old.read_text(encoding="utf-8"))
    assert document["schema"] == "motorid-estimate-1"
    VALIDATOR.validate(document)


def test_moves_are_said_where_there_are_some() -> None:
    moved = Suspect("current_lag", "current", "it is late", "declare it", "named", {"R": 0.1})
    endless = Diagnostic("lack_of_fit", "warning", "it lacks something", {"K": math.inf})
    doubted = settled(estimate(suspects=(moved,), diagnostics=(endless,)), [moved])
    read = json_.to_dict(doubted)
    VALIDATOR.validate(read)
    assert read["suspects"][0]["moves"] == {"R": 0.1}
    assert read["diagnostics"][0]["moves"] == {"K": None}
    assert read["parameters"]["R"]["status"] == "doubtful"
    assert "moves" not in json_.to_dict(estimate())["diagnostics"][0]


def test_a_value_that_is_not_supported_is_null() -> None:
    read = json_.to_dict(refused(estimate(), Unexplained("current", 0.9, 0.9, declared=False)))
    VALIDATOR.validate(read)
    assert read["diagnostics"][0]["code"] == "not_supported"
    assert {(p["value"], p["status"]) for p in read["parameters"].values()} == {
        (None, "not_supported")
    }
    read["parameters"]["R"]["value"] = 2.0
    assert not VALIDATOR.is_valid(read)
