"""An estimate as path -> value: its published JSON laid flat, without what differs by the day."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from motorid.report.json_ import to_dict

if TYPE_CHECKING:
    from motorid.estimate.results.estimate import Estimate

Value = float | int | str | bool | None
Flat = dict[str, Value]
SPLIT = " > "  # names hold dots and strokes
LEFT_OUT = ("versions", "content_sha256")
LEFT_OUT_OF_INPUTS = ("path",)
NAMED_BY = (("code", "where"), ("code",), ("capture", "channel"), ("name",))  # of rows in a list


def flat(estimate: Estimate) -> Flat:
    """Every number and every word of an estimate. Raises ValueError where two share a path."""
    tree = {name: part for name, part in to_dict(estimate).items() if name not in LEFT_OUT}
    tree["inputs"] = [
        {k: v for k, v in one.items() if k not in LEFT_OUT_OF_INPUTS} for one in tree["inputs"]
    ]
    tree["correlation"] = _pairs(tree["correlation"])
    found: Flat = {}
    for path, value in _leaves(tree, ()):
        key = SPLIT.join(path)
        if key in found:
            raise ValueError(f"two values have the path {key!r}")
        found[key] = value
    return found


def _pairs(correlation: Mapping[str, Any]) -> dict[str, Any]:
    """Correlations by the two names, each pair once."""
    names, matrix = correlation["names"], correlation["matrix"]
    return {
        "names": " ".join(names),
        **{a: {b: matrix[i][j] for j, b in enumerate(names[:i])} for i, a in enumerate(names)},
    }


def _leaves(node: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Value]]:
    if isinstance(node, Mapping):
        for name, part in node.items():
            yield from _leaves(part, (*path, str(name)))
    elif isinstance(node, list):
        names = _names(node)
        if names != [str(k) for k in range(len(node))]:
            yield (*path, "order"), ", ".join(names)
        for name, part in zip(names, node, strict=True):
            yield from _leaves(part, (*path, name))
    else:
        yield path, node


def _names(rows: Sequence[Any]) -> list[str]:
    """Of the rows of a list: what they say of themselves, else their number.

    A row that comes or goes then moves no other.
    """
    for keys in NAMED_BY:
        if rows and all(isinstance(row, Mapping) and set(keys) <= row.keys() for row in rows):
            seen: Counter[str] = Counter()
            names = []
            for row in rows:
                name = " ".join(str(row[key]) for key in keys)
                seen[name] += 1
                names.append(name if seen[name] == 1 else f"{name} #{seen[name]}")
            return names
    return [str(k) for k in range(len(rows))]
