"""The published schemas: valid themselves, and true of what motorid writes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import jsonschema
import pytest

from motorid import schemas
from motorid.quality import records
from motorid.quality.judge import not_measured
from motorid.quality.product import Product
from motorid.workflow.check import judge_files
from tests.plant.consumer import valid
from tests.quality.conftest import good, line_rig, measure, product  # noqa: F401 - fixtures

WHO = {"station": "line-1", "operator": "anna", "retest": ""}


@pytest.mark.parametrize("name", schemas.names())
def test_each_is_a_schema(name: str) -> None:
    found = schemas.schema(name)
    jsonschema.Draft202012Validator.check_schema(found)
    assert found["$id"].startswith(f"urn:motorid:{name}:")


def test_the_page_lists_each() -> None:
    page = (Path(__file__).parents[2] / "docs" / "schemas.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| `([\w-]+)` \|", page, re.MULTILINE)) == list(schemas.names())


@pytest.mark.slow
def test_a_verdict_follows_its_schema(good: Path, product: Product) -> None:  # noqa: F811
    judged, _ = judge_files([good], product)
    assert judged.measurements
    for verdict in (judged, not_measured(product, "", "no rig")):
        said = json.loads(records.to_json(verdict, who=WHO))
        valid(said, "verdict")
        for wrong in ({"outcome": "GOOD"}, {"measurements": [{}]}, {"content_sha256": "x"}):
            with pytest.raises(jsonschema.ValidationError):
                valid({**said, **wrong}, "verdict")
