"""What an export refuses, says and refers to another shaft; and that no text of others escapes."""

from __future__ import annotations

import copy
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motorid import json_text
from motorid.cli import main
from motorid.errors import DataError
from motorid.estimate.results.estimate import PARAMETERS
from motorid.export.targets import NAMES, TABLE, export
from tests.export.estimates import TRUE, document


@pytest.fixture
def estimate(tmp_path: Path) -> Any:
    def written(**changed: dict[str, Any]) -> Path:
        path = tmp_path / "estimate.json"
        path.write_text(json_text.dumps(document(**changed)), encoding="utf-8")
        return path

    return written


UNKNOWN = {"value": None, "interval_95": None, "status": "not_identifiable", "note": "no motion"}


@pytest.mark.slow
@pytest.mark.parametrize("to", NAMES)
def test_what_is_unknown_or_doubtful_is_refused(
    to: str, estimate: Any, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for name in PARAMETERS if to != "fmu" else ("L",):  # each makes the compiler run
        for changed in (UNKNOWN, {"status": "doubtful", "note": "a brush"}, {"status": "at_bound"}):
            line = ["export", str(estimate(**{name: changed})), "--to", to]
            out = ["-o", str(tmp_path / f"{name}-{changed['status']}")]
            code = main.run([*line, *out])
            said = capsys.readouterr().err
            held = name in next(target.holds for target in TABLE if target.name == to)
            assert code == (4 if held else 0)
            if held:
                assert f"{name} " in said
                assert "--set" in said or "--allow-doubtful" in said
            if held and changed is not UNKNOWN:
                assert main.run([*line, *out, "--allow-doubtful"]) == 0
                assert f"{name} is {changed['status']}" in capsys.readouterr().err


def test_the_estimate_is_never_exported_without_its_standing(estimate: Any) -> None:
    path = estimate(K={"status": "doubtful", "note": "a brush"})
    for to in set(NAMES) - {"fmu", "json", "toml"}:
        text = export(path, to, allow_doubtful=True).content.decode()
        assert "doubtful (a brush)" in text, to


def test_a_stated_value_takes_the_place_of_an_unknown_one(estimate: Any) -> None:
    made = export(estimate(L=UNKNOWN), "json", given={"L": 1e-3})
    data = json_text.loads(made.content)
    assert data["parameters"]["L"]["value"] == 1e-3
    assert data["parameters"]["L"]["status"] == "given"
    row = data["covariance"]["matrix"][PARAMETERS.index("L")]
    assert row == [0.0] * 6
    assert any(sentence.startswith("L is given") for sentence in made.said)


def test_the_output_of_a_gear(estimate: Any) -> None:
    data = tomllib.loads(export(estimate(), "toml", gear_ratio=10.0).content.decode())
    powers = {"R": 1.0, "L": 1.0, "K": 10.0, "B": 100.0, "J": 100.0, "T0": 10.0}
    for name, power in powers.items():
        said = data["parameters"][name]
        assert said["value"] == pytest.approx(power * TRUE[name])
        assert said["standard_uncertainty"] == pytest.approx(0.01 * power * TRUE[name])
        assert said["interval_95"] == pytest.approx(
            [0.98 * power * TRUE[name], 1.02 * power * TRUE[name]]
        )
    matrix = data["covariance"]["matrix"]
    assert matrix[0][2] == pytest.approx(0.25 * 0.025 * 0.77e-3)
    assert matrix[3][3] == pytest.approx((0.01 * 100 * TRUE["B"]) ** 2)


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (["--to", "mujuco"], 2),
        (["--to", "json", "--gear-ratio", "0"], 2),
        (["--to", "json", "--gear-ratio", "-3"], 2),
        (["--to", "json", "--set", "Q=1"], 2),
        (["--to", "json", "--set", "J=0"], 2),
        (["--to", "control", "--set", "L=0"], 4),
        (["--to", "mujoco", "--set", "L=0"], 0),
        (["--to", "fmu"], 2),
    ],
)
def test_options(
    options: list[str], code: int, estimate: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main.run(["export", str(estimate()), *options]) == code
    assert "internal" not in capsys.readouterr().err


def test_a_linear_axis_is_no_turning_motor(estimate: Any) -> None:
    with pytest.raises(DataError, match="linear axis"):
        export(estimate(J={"unit": "kg"}), "json")


def test_texts_of_others_end_no_comment(estimate: Any) -> None:
    path = estimate()
    for to in ("mujoco", "urdf"):
        ET.fromstring(export(path, to).content)
    compile(export(path, "control").content, "motor.py", "exec")
    for line in export(path, "spice").content.decode().splitlines():
        assert line.startswith(("*", ".subckt motor", "+", *"VRLEFCB", ".ends motor")), line
    tomllib.loads(export(path, "toml").content.decode())


def test_each_that_is_not_run_says_so(estimate: Any) -> None:
    for target in TABLE:
        if not target.run:
            made = export(estimate(), target.name)
            assert "not run here" in made.content.decode()
            assert "not run here" in made.said[0]


def paths(value: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where each member of a document is."""
    inner = value.items() if isinstance(value, dict) else enumerate(value)
    found = [((*at, key), one) for key, one in inner] if isinstance(value, dict | list) else []
    return [p for p, _ in found] + [
        deep for p, one in found if isinstance(one, dict | list) for deep in paths(one, p)
    ]


VALUES = st.one_of(
    st.none(), st.booleans(), st.floats(allow_nan=False, allow_infinity=False), st.text(max_size=5),
    st.just([]), st.just({}), st.integers(-(10**20), 10**20),
)  # fmt: skip


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(st.sampled_from(paths(document())), VALUES, st.sampled_from(["mujoco", "json", "toml"]))
def test_a_damaged_estimate_is_exported_or_refused_in_a_sentence(
    tmp_path_factory: pytest.TempPathFactory, where: tuple[Any, ...], value: Any, to: str
) -> None:
    spoilt = copy.deepcopy(document())
    inner: Any = spoilt
    for key in where[:-1]:
        inner = inner[key]
    inner[where[-1]] = value
    path = tmp_path_factory.getbasetemp() / "spoilt.json"
    path.write_text(json_text.dumps(spoilt), encoding="utf-8")
    try:
        content = export(path, to).content.decode()
    except DataError:
        return
    assert "nan" not in content
    {"mujoco": ET.fromstring, "json": json_text.loads, "toml": tomllib.loads}[to](content)
