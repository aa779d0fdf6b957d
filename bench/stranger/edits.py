"""What is done to a table of readings: clipped, shifted, held, smoothed, rows gone."""

from __future__ import annotations

import numpy as np

from bench.mistakes.plant import Motor
from bench.stranger.logs import Edit, Table


def clipped(share: float) -> Edit:
    """A current that stops at that share of stall."""
    return lambda table, m: {
        **table,
        "i": np.clip(table["i"], -share * m.stall_a, share * m.stall_a),
    }


def offset(share: float) -> Edit:
    """A current whose zero lies at that share of stall."""
    return lambda table, m: {**table, "i": table["i"] + share * m.stall_a}


def turned(column: str) -> Edit:
    """A column of the other sign."""
    return lambda table, m: {**table, column: -table[column]}


def held(column: str, rows: int) -> Edit:
    """A column that is read anew only every so many rows."""

    def edit(table: Table, m: Motor) -> Table:
        at = np.arange(len(table["t"]))
        return {**table, column: table[column][at - at % rows]}

    return edit


def smoothed(column: str, rows: int) -> Edit:
    """A column of means over its last rows."""

    def edit(table: Table, m: Motor) -> Table:
        padded = np.concatenate([np.full(rows - 1, table[column][0]), table[column]])
        return {**table, column: np.convolve(padded, np.full(rows, 1.0 / rows), "valid")}

    return edit


def gone(table: Table, m: Motor) -> Table:
    """A tenth of the rows in ten pieces, and the stamps written anew."""
    at = np.arange(len(table["t"]))
    kept = at % max(len(at) // 10, 10) > max(len(at) // 100, 2)
    return {name: x[: kept.sum()] if name == "t" else x[kept] for name, x in table.items()}
