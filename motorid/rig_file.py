"""Reads a rig's TOML file: every key known, typed and within reason, or one clear sentence."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, get_args

from motorid.capture.model import CURRENT, Curve, Wiring
from motorid.errors import RigError
from motorid.program import Program
from motorid.rig_keys import (
    CALIBRATION,
    CALIBRATION_FILE,
    CHANNELS,
    REQUIRED,
    SECTIONS,
    Key,
    Text,
    read_table,
    show,
)
from motorid.rig_model import Calibration, Limits, Nameplate, Rig, Sampling
from motorid.rig_steps import read_program
from motorid.toml_file import packaged, read_text, tables_of, unknown

NO_BOARD = "scpi://"  # instruments, which need no encoder
TOP = ("name", "port", "board_serial", "front_end")


def load(name_or_path: str) -> Rig:
    """The rig of a preset's name or of a file, with its calibration file. Raises RigError."""
    path = find(name_or_path)
    return _calibrated(_with_front_end(load_plain(path)), path)


def load_plain(path: Path) -> Rig:
    """The rig of a file as it stands, whatever calibration lies beside it. Raises RigError."""
    return parse(read_text(path, "a rig file", RigError), str(path))


def _with_front_end(rig: Rig) -> Rig:
    """With what the front end that it names says of its sensor and no board holds."""
    if not rig.front_end:
        return rig
    from motorid.rig_front_end import load_front_end

    return load_front_end(rig.front_end, Path(rig.folder) if rig.folder else None).under(rig)


def _calibrated(rig: Rig, path: Path) -> Rig:
    """With the calibration that the rig file names, or else the one beside it, if there is any."""
    from motorid.rig_calibration import apply, path_beside, read_calibration

    beside = path_beside(path)
    if rig.calibration_file:
        return apply(rig, read_calibration(path.parent / rig.calibration_file))
    return apply(rig, read_calibration(beside)) if beside.is_file() else rig


def parse(text: str, where: str = "rig") -> Rig:
    """The rig that ``text`` (TOML) describes; ``where`` names it in errors. Raises RigError."""
    return _Reader(where).rig(tables_of(text, where, RigError), text)


def presets() -> tuple[str, ...]:
    """Names that ``--rig`` takes without a path."""
    return tuple(sorted(path.stem for path in packaged("rigs").glob("*.toml")))


class _Reader:
    """Checks one document; every error names the file."""

    def __init__(self, where: str) -> None:
        self.where = where

    def fail(self, message: str) -> RigError:
        return RigError(f"{self.where}: {message}")

    def rig(self, document: dict[str, Any], text: str) -> Rig:
        self._known(document, (*TOP, *SECTIONS, "calibration"), "")
        sections = {
            name: self.table(document.get(name, {}), keys, name)
            for name, keys in SECTIONS.items()
            if name != "program"
        }
        top = self.table(
            {key: document[key] for key in TOP if key in document},
            dict.fromkeys(TOP, Text()),
            "",
        )
        for name, required in REQUIRED.items():
            for key in required:
                if key not in sections[name]:
                    raise self.fail(f"{name}.{key} is missing: it has no safe default")
        program = read_program(document, Nameplate(**sections["nameplate"]), self.where)
        rig = self._build(top, sections, program, self._calibration(document), text)
        return self._with_age(rig, document)

    def _build(
        self,
        top: dict[str, Any],
        sections: dict[str, dict[str, Any]],
        program: Program,
        calibration: dict[str, Calibration],
        text: str,
    ) -> Rig:
        wiring = sections["wiring"]
        apart = ("encoder_reversed", "voltage_sense", "supply_voltage_v")
        rig = Rig(
            name=top.get("name", Path(self.where).stem),
            port=top.get("port", ""),
            board_serial=top.get("board_serial", ""),
            front_end=top.get("front_end", ""),
            folder=str(Path(self.where).parent),
            wiring=Wiring(**{f.name: wiring[f.name] for f in fields(Wiring) if f.name in wiring}),
            limits=Limits(**sections["limits"]),
            nameplate=Nameplate(**sections["nameplate"]),
            sampling=Sampling(**sections["sampling"]),
            program=program,
            **{k: v for k, v in wiring.items() if k in apart},
            **sections["conditions"],
            thermal=sections["thermal"],
            calibration=calibration,
            text=text,
        )
        self._consistent(rig)
        return rig

    def _consistent(self, rig: Rig) -> None:
        limits = rig.limits
        if limits.supply_min_v >= limits.supply_max_v:
            raise self.fail("limits.supply_min_v must be below limits.supply_max_v")
        stated = rig.supply_voltage_v
        if stated is not None and not limits.supply_min_v <= stated <= limits.supply_max_v:
            raise self.fail(
                f"wiring.supply_voltage_v = {stated:g} is not within limits.supply_min_v = "
                f"{limits.supply_min_v:g} and limits.supply_max_v = {limits.supply_max_v:g}: "
                "correct the one that is wrong"
            )
        self._whole(rig)
        if len(set(rig.sampling.channels)) < len(rig.sampling.channels):
            raise self.fail("sampling.channels names a channel twice")
        if not rig.wiring.counts_per_turn and not rig.port.startswith(NO_BOARD):
            raise self.fail(
                "wiring.counts_per_turn is missing: the speed limit and the position need it "
                "(counts, four a line, of one turn of the encoder's shaft)"
            )

    def _whole(self, rig: Rig) -> None:
        """A drift has its time, a non-linearity its shape, and it is the current's."""
        wiring = rig.wiring
        if _parted(wiring.reference_drift, wiring.reference_time_s):
            raise self.fail(
                "wiring.reference_drift and wiring.reference_time_s go together: by which share "
                "the converter's reference may drift in a run, and over how many seconds"
            )
        for name, known in rig.calibration.items():
            said = f"calibration.{name}.nonlinearity"
            stated = (known.nonlinearity, known.nonlinearity_shape, known.full_scale)
            if name != CURRENT and stated != (None, None, None):
                raise self.fail(f"{said} is of the current alone: take it out")
            if _parted(known.nonlinearity, known.nonlinearity_shape):
                raise self.fail(
                    f"{said} and {said}_shape go together: a share of full scale, and one of "
                    f"{', '.join(get_args(Curve))}"
                )

    def table(self, table: Any, keys: Mapping[str, Key], name: str) -> dict[str, Any]:
        """The values of one table, checked. Raises RigError naming the key."""
        return read_table(table, keys, name, self.where)

    def _known(self, table: Mapping[str, Any], keys: tuple[str, ...], name: str) -> None:
        if problem := unknown(table, keys, name):
            raise self.fail(problem)

    def _calibration(self, document: dict[str, Any]) -> dict[str, Calibration]:
        tables = document.get("calibration", {})
        if not isinstance(tables, dict):
            raise self.fail(f"[calibration] must be a table, not {show(tables)}")
        self._known(tables, (*CHANNELS, *CALIBRATION_FILE), "calibration")
        return {
            name: Calibration(**self.table(table, CALIBRATION, f"calibration.{name}"))
            for name, table in tables.items()
            if name not in CALIBRATION_FILE
        }

    def _with_age(self, rig: Rig, document: dict[str, Any]) -> Rig:
        given = document.get("calibration", {})
        table = {key: given[key] for key in CALIBRATION_FILE if key in given}
        found = self.table(table, CALIBRATION_FILE, "calibration")
        return replace(rig, **{f"calibration_{key}": value for key, value in found.items()})


def _parted(size: float | None, of: float | str | None) -> bool:
    """A size without what it needs, or that without a size; a size of 0 needs nothing."""
    return (bool(size) and not of) or (bool(of) and size is None)


def find(name_or_path: str) -> Path:
    """The file meant: a path as it stands, or a preset. Raises RigError."""
    path = Path(name_or_path)
    bare = path.name == name_or_path and path.suffix == ""
    preset = packaged("rigs") / f"{name_or_path}.toml"
    if bare and preset.is_file():
        return preset
    if "\0" not in name_or_path and path.is_file():
        return path
    near = difflib.get_close_matches(path.stem, presets(), n=1)
    hint = f"; did you mean {near[0]}?" if near else f"; presets are {', '.join(presets())}"
    raise RigError(f"no rig file {show(name_or_path)}{hint}")
