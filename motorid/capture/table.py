"""Makes a capture of somebody else's file: a table and a map of its columns."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from motorid.capture import table_checks as checks
from motorid.capture.columns import Columns, Source
from motorid.capture.continued_stamps import without_stale
from motorid.capture.declared import drift, without_early_readings
from motorid.capture.drive_sign import with_sign
from motorid.capture.facts import IMPORTED, kept
from motorid.capture.formats import source_of
from motorid.capture.mapping import ROW, ChannelMap, Formula, parse_maps
from motorid.capture.model import HELD as HELD
from motorid.capture.model import NOTES as NOTES
from motorid.capture.model import POSITION, VOLTAGE, Capture, Channel, Sense, Wiring
from motorid.capture.reading_step import reading_step
from motorid.capture.stamps import CLOCK_HZ as CLOCK_HZ
from motorid.capture.stamps import Clock, clock_of
from motorid.capture.table_options import (
    TableOptions,
    as_stated,
    insist_options,
    stated_options,
)
from motorid.capture.units import AMBIENT, TIME
from motorid.capture.wrapped_position import continued
from motorid.errors import DataError, UsageError
from motorid.reading import open_file
from motorid.version import __version__

Floats = NDArray[np.float64]
STAMPS = "stamps"  # provenance: the period and rounding of stamps that a uniform grid explains
STATIC = "static"  # provenance: True where the rows are steady points without an order in time


def read_table(path: str | Path, maps: Sequence[str], **options: Any) -> Capture:
    """The capture that ``maps`` makes of the file at ``path``, of a kind of ``formats.TABLE``.

    ``maps`` are ``QUANTITY=EXPRESSION:UNIT``; an expression is a column's name or arithmetic over
    columns and constants (``torque=vir*gtau:N``). Quantities are ``units.QUANTITIES`` and
    ``voltage``. Without ``time`` the rows are steady points. ``options`` are the fields of
    ``TableOptions`` (None: its default); ``drop_bad`` leaves out cells with text,
    nothing or sentinels, and rows without a good cell or whose stamps step back, which otherwise
    raise DataError with their place. A current
    that is never negative while the speed reverses is taken as a magnitude. What is odd but stops
    nothing is in ``provenance["notes"]``.

    Raises UsageError on a bad map, unit or option, DataError on a bad file.
    """
    given = {name: value for name, value in options.items() if value is not None}
    path, chosen = Path(path), TableOptions(**given)
    mapped = parse_maps(maps, chosen.counts_per_turn)
    insist_options(chosen, mapped)
    drifting = drift(chosen.reference_drift) if chosen.reference_drift else {}
    source = source_of(path, chosen)
    formulas = _formulas(source, mapped, chosen.constants)
    notes = [*chosen.notes, *checks.header_notes(mapped, formulas, source.header_units)]
    values = _read(path, source, formulas, chosen, notes)
    clock, values, static = _in_order(path, source, mapped, values, chosen, notes)
    checks.some_readings(path, values)
    if POSITION in values and not static:
        values[POSITION] = continued(values[POSITION], chosen.counts_per_turn, notes)
    channels = {
        name: _channel(one, values[name], chosen)
        for name, one in mapped.items()
        if name not in (TIME, AMBIENT)
    }
    ambient, doubt = _ambient(values.get(AMBIENT), chosen)
    held = {} if static else checks.held_samples(channels)
    channels = checks.with_magnitudes(channels, notes)
    if not static:
        channels = with_sign(channels, clock.ticks / clock.hz, notes)
    capture = Capture(
        ticks=clock.ticks,
        clock_hz=clock.hz,
        clock_uncertainty=clock.uncertainty,
        channels=channels,
        wiring=Wiring(
            gear_ratio=chosen.gear_ratio,
            counts_per_turn=chosen.counts_per_turn,
            bridge_resistance_ohm=chosen.bridge_resistance,
            bridge_resistance_uncertainty_ohm=chosen.bridge_resistance_uncertainty,
            encoder_eccentricity_rad=chosen.eccentricity,
            **drifting,
        ),
        gaps=() if static else checks.gaps(clock.ticks, notes),
        ambient_c=ambient,
        ambient_uncertainty_c=doubt,
        stated=chosen.stated,
    )
    notes += checks.capture_notes(capture, held, static)
    kept = capture.channels if static else without_early_readings(capture.channels)
    found = {NOTES: notes, HELD: held, STATIC: static, **_of_stamps(clock, mapped)}
    return replace(
        capture,
        channels={name: replace(one) for name, one in kept.items()},  # raw data alone
        provenance=_provenance(path, maps, source, chosen) | found,
    )


def _formulas(
    source: Source, mapped: Mapping[str, ChannelMap], constants: Mapping[str, float]
) -> dict[str, Formula]:
    """What each map asks of the file. Raises UsageError for a column that it does not have."""
    try:
        return {n: Formula(m.expression, source.names, constants) for n, m in mapped.items()}
    except UsageError as error:
        if not source.elsewhere:
            raise
        raise UsageError(f"{error}; {source.elsewhere}") from None


def _read(
    path: Path,
    source: Source,
    formulas: Mapping[str, Formula],
    chosen: TableOptions,
    notes: list[str],
) -> dict[str, Floats]:
    """Each quantity in its own unit, good rows only, and ``row``: their places in the file."""
    wanted = dict.fromkeys(column for formula in formulas.values() for column in formula.columns)
    columns = source.read([name for name in wanted if name != ROW])
    if chosen.missing:
        columns = checks.without_told(columns, chosen.missing, notes)
    columns = checks.good_cells(path, source, columns, chosen.drop_bad, notes)
    values = {
        name: formula.evaluate(columns.values, columns.rows) for name, formula in formulas.items()
    }
    rows = np.arange(columns.rows, dtype=np.float64)
    for name, formula in formulas.items() if not chosen.drop_bad else ():
        wrong = _undefined(formula, columns, values[name])
        if wrong.any():
            raise DataError(
                f"{path}: {source.place(int(np.argmax(wrong)))}: {name} = {formula.text} is not "
                "finite there (a division by zero?): repair it, or leave such rows out with "
                "--drop-bad"
            )
    del columns
    return _chosen(_usable(values), {ROW: rows, **values})


def _undefined(formula: Formula, columns: Columns, values: Floats) -> NDArray[np.bool_]:
    """Rows whose value is not finite though every reading that it needs is, (rows,)."""
    wrong = ~np.isfinite(values)
    for name in formula.columns if wrong.any() else ():
        if name != ROW:
            wrong = wrong & np.isfinite(columns.values[name])
    return wrong


def _chosen(rows: NDArray[np.bool_], columns: Mapping[str, Floats]) -> dict[str, Floats]:
    """Those rows of the columns; not copied where that is all of them, for they may be large."""
    if rows.all():
        return dict(columns)
    return {name: column[rows] for name, column in columns.items()}


def _usable(values: Mapping[str, Floats]) -> NDArray[np.bool_]:
    """Rows with a time and any reading beside it; steady points need every one. Shape (rows,)."""
    finite = {name: np.isfinite(column) for name, column in values.items()}
    time = finite.pop(TIME, None)
    if time is None:
        return np.asarray(np.all(list(finite.values()), axis=0))
    return np.asarray(time & np.any(list(finite.values()), axis=0))


def _in_order(
    path: Path,
    source: Source,
    mapped: Mapping[str, ChannelMap],
    values: dict[str, Floats],
    chosen: TableOptions,
    notes: list[str],
) -> tuple[Clock, dict[str, Floats], bool]:
    """The clock, the values that belong to its ticks, and whether the rows have no time."""
    if TIME not in mapped:
        rows = len(values[ROW])
        if not rows:
            raise DataError(f"{path} holds no usable row")
        return Clock(np.arange(rows, dtype=np.int64) * int(CLOCK_HZ)), values, True
    unit_s = mapped[TIME].unit.scale
    stamps = values[TIME]
    time_s = stamps * unit_s
    inside = (time_s >= chosen.start_s) & (time_s <= chosen.stop_s)
    if inside.sum() < 2:
        raise DataError(f"{path} holds {inside.sum()} usable rows there: a capture needs two")
    if np.ptp(time_s) * CLOCK_HZ >= 2**62:
        raise DataError(f"{path}: the time column spans {np.ptp(time_s):g} s: is its unit right?")
    del time_s
    early = without_stale(stamps[inside], unit_s, notes)
    inside[np.flatnonzero(inside)[:early]] = False
    stamps = stamps if inside.all() else stamps[inside]
    values = _chosen(inside, {n: column for n, column in values.items() if n != TIME})
    clock = clock_of(path, source, stamps, unit_s, values, chosen.drop_bad, notes)
    if len(clock.ticks) < 2:
        raise DataError(f"{path}: the time column does not advance: is it the right column?")
    return clock, values if clock.ahead is None else _chosen(clock.ahead, values), False


def _of_stamps(clock: Clock, mapped: Mapping[str, ChannelMap]) -> dict[str, Any]:
    """For the provenance: the grid that replaced the file's stamps, if one did."""
    if clock.grid is None:
        return {}
    unit_s = mapped[TIME].unit.scale
    said = {
        "period_s": clock.grid.period * unit_s,
        "resolution_s": float(f"{clock.grid.resolution * unit_s:.3g}"),
    }
    return {STAMPS: said}


def _channel(one: ChannelMap, raw: Floats, chosen: TableOptions) -> Channel:
    return as_stated(
        Channel(
            name=one.quantity,
            unit=one.unit.si,
            raw=raw,
            scale=one.unit.scale,
            resolution=(1.0 if one.unit.counts else reading_step(raw)) * one.unit.scale,
            sense=cast(Sense, chosen.sense) if one.quantity == VOLTAGE else None,
            unsigned=one.quantity in chosen.unsigned,
        ),
        chosen,
        counted=one.unit.counts,
    )


def _ambient(sensed: Floats | None, chosen: TableOptions) -> tuple[float | None, float]:
    """°C and standard uncertainty: as given, or the mean of a thermometer's readings.

    A thermometer's own uncertainty is its offset's; how far the room drifted adds to that.
    """
    if sensed is None or chosen.ambient_c is not None:
        return chosen.ambient_c, chosen.ambient_uncertainty_c
    own = max(chosen.offset_uncertainty.get(AMBIENT, 0.0), chosen.ambient_uncertainty_c)
    return float(np.nanmean(sensed)), float(np.hypot(own, np.nanstd(sensed)))


def _provenance(
    path: Path, maps: Sequence[str], source: Source, chosen: TableOptions
) -> dict[str, Any]:
    return {
        "imported_from": path.name,
        "imported_sha256": _sha256(path),
        "imported_by": f"motorid {__version__}",
        "maps": list(maps),
        "layout": source.layout,
        "constants": dict(chosen.constants),
        "declared": stated_options(chosen),
        IMPORTED: kept(chosen.stated),
        "serial": chosen.serial,
        "note": chosen.note,
    }


def _sha256(path: Path) -> str:
    with open_file(path, DataError) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
