"""JSON that any other program reads: strict on the way in, strict on the way out."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from motorid import json_text
from motorid.errors import DataError


def strictly(text: str) -> Any:
    """As a reader that knows nothing of Python's own extensions."""

    def refuse(name: str) -> Any:
        raise AssertionError(f"{name} in {text}")

    text.encode("utf-8")
    return json.loads(text, parse_constant=refuse)


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(st.characters()),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=10,
)


@pytest.mark.slow
@hypothesis.given(ANYTHING)
@hypothesis.settings(max_examples=150)
def test_what_is_written_is_strict(value: Any) -> None:
    text = json_text.dumps(value)
    strictly(text)
    assert not {c for c in text if ord(c) < 32 or 0x7F <= ord(c) < 0xA0}


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, np.float64("nan")])
def test_what_is_not_finite_is_null(value: float) -> None:
    assert strictly(json_text.dumps({"a": [value], "b": np.array([value, 1.0])})) == {
        "a": [None],
        "b": [None, 1.0],
    }
    assert strictly(json_text.canonical([value])) == [None]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("NaN", "NaN"),
        ('{"id": -Infinity}', "Infinity"),
        ('{"id": 1e999}', "out of range"),
        (f"[{'9' * 400}]", "out of range"),
        (f"[{'9' * 5000}]", "out of range"),
        ('["\\ud800"]', "surrogate"),
        ('{"\\uDFFF": 1}', "surrogate"),
        ('["\ud800"]', "surrogate"),
        (b'["\xff"]', "UTF-8"),
        ("[" * 100_000, "deeply"),
        ('{"a": 1, "a": 2}', "twice"),
        ("", "value"),
        ("{} x", "data"),
    ],
)
def test_what_is_not_strict_is_refused_in_words(text: str | bytes, said: str) -> None:
    with pytest.raises(json_text.JsonError, match=said):
        json_text.loads(text)


def test_what_is_strict_is_read() -> None:
    assert json_text.loads(b'\xef\xbb\xbf{"a": [1, 2.5, null, "\\ud83d\\ude00 \xc2\xb5"]}') == {
        "a": [1, 2.5, None, "\U0001f600 µ"]
    }


def test_a_file_says_its_name(tmp_path: Path) -> None:
    path = tmp_path / "order.json"
    for data, said in ((b"[1]", "object"), (b"{", "not JSON"), (b'{"a": NaN}', "NaN")):
        path.write_bytes(data)
        with pytest.raises(DataError, match=f"order.json.*{said}"):
            json_text.read_object(path, DataError)
    with pytest.raises(DataError, match="cannot be read"):
        json_text.read_object(tmp_path / "absent", DataError)
