"""Imports point down only, and heavy modules stay unloaded until they are needed."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from tests.import_statements import imported, names

PACKAGE = Path(__file__).resolve().parent.parent / "motorid"
BASE = {
    "look",
    "errors",
    "toml",
    "version",
    "visible",
    "json",
    "csv",
    "reading",
    "limits",
    "schemas",
}
DATA = BASE | {"program", "capture"}
FIT = DATA | {"motor", "segment", "estimate", "plan", "search", "identify"}
DRIVE = DATA | {"rig", "wire", "sim", "acquire"}
MAY_IMPORT = {
    "errors": set[str](),
    "look": set[str](),  # reaches up by name, when a person asks for a view
    "toml": {"errors", "reading", "limits"},
    "limits": {"errors", "reading", "visible"},
    "version": set[str](),
    "visible": set[str](),
    "json": {"errors", "visible", "reading", "limits"},
    "csv": {"visible"},
    "schemas": {"json"},
    "reading": {"errors", "visible"},
    "wire": BASE,
    "program": BASE,
    "excitation": BASE | {"program"},
    "capture": DATA,
    "rig": DATA | {"excitation", "wire"},
    "calibration": DATA,
    "segment": DATA,
    "motor": DATA,
    "estimate": DATA | {"motor", "segment"},
    "search": FIT - {"plan"} | {"search"},
    "identify": FIT - {"plan"} | {"search"},
    "plan": FIT | {"excitation", "rig"},
    "storage": DATA,
    "quality": FIT | {"quality"},
    "report": FIT | {"quality", "report"},
    "export": DATA | {"estimate"},
    "sim": DATA | {"rig", "wire"},
    "acquire": DRIVE,
    "workflow": DRIVE | FIT | {"calibration", "quality", "report", "storage", "workflow"},
    "web": DRIVE | FIT | {"quality", "report", "storage", "workflow"},
    "api": DRIVE | FIT | {"calibration", "quality", "report", "workflow"},
    "cli": DRIVE
    | FIT
    | {"calibration", "export", "quality", "report", "storage", "web", "workflow"},
}


def room(module: str) -> str | None:
    """The room of a dotted module of motorid: ``motorid.rig_file`` is in ``rig``.

    ``motorid.__main__`` is the command line's other door.
    """
    parts = module.split(".")
    if parts[0] != "motorid" or len(parts) == 1:
        return None
    return "cli" if parts[1] == "__main__" else parts[1].split("_")[0]


def files() -> list[Path]:
    """Every module but motorid/__init__.py, the public face, which reaches all rooms lazily."""
    return [path for path in sorted(PACKAGE.rglob("*.py")) if path != PACKAGE / "__init__.py"]


@pytest.mark.parametrize("path", files(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_down(path: Path) -> None:
    own = room(".".join(("motorid", *path.relative_to(PACKAGE).with_suffix("").parts)))
    assert own in MAY_IMPORT, "a new room: say in MAY_IMPORT what it may know"
    reached = {found for module in imported(path) if (found := room(module))}
    assert reached - MAY_IMPORT[own] - {own} == set()


def test_nothing_inside_imports_the_public_face() -> None:
    """``motorid/__init__.py`` reaches every room, so a room must not import it."""
    for path in files():
        reached = {module for module in imported(path) if module.split(".")[0] == "motorid"}
        assert reached & {"motorid", "motorid.__version__"} == set(), path


def test_json_and_csv_are_written_in_one_place() -> None:
    """Python's own json writes NaN, its csv writes formulas; both have one guarded door."""
    doors = {"json": {"json_text.py"}, "csv": {"csv_text.py", "csv_reader.py", "study_file.py"}}
    for path in files():
        for module in imported(path) & set(doors):
            assert path.name in doors[module], f"{path} imports {module}: see {doors[module]}"


def among_themselves(modules: dict[str, Path]) -> dict[str, set[str]]:
    """Which of some modules each of them imports, at its top, inside functions or for types."""
    return {name: imported(path) & modules.keys() - {name} for name, path in modules.items()}


def circle(arrows: dict[str, set[str]]) -> list[str]:
    """Modules that import one another in a ring, or that lead to one; none where there is none."""
    left = dict(arrows)
    while free := [name for name, targets in left.items() if not targets & left.keys()]:
        for name in free:
            del left[name]
    return sorted(left)


@pytest.mark.parametrize("own", ["acquire", "capture", "rig"])
def test_no_module_of_a_room_reaches_itself(own: str) -> None:
    dotted = {
        ".".join(("motorid", *p.relative_to(PACKAGE).with_suffix("").parts)): p for p in files()
    }
    modules = {name: path for name, path in dotted.items() if room(name) == own}
    assert len(modules) >= 4
    assert circle(among_themselves(modules)) == []


def test_a_circle_is_seen() -> None:
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()}) == ["a", "b", "c"]


def test_a_circle_is_seen_in_every_way_to_import(tmp_path: Path) -> None:
    modules = {f"motorid.acquire.{name}": tmp_path / name for name in ("port", "relay", "journal")}
    port, relay, journal = modules.values()
    port.write_text("def f():\n    from motorid.acquire.relay import g\n")
    relay.write_text("from motorid.acquire import journal\n")
    journal.write_text("import motorid.acquire.port\n")
    assert circle(among_themselves(modules)) == sorted(modules)
    journal.write_text("import struct\n")
    assert circle(among_themselves(modules)) == []


def loaded_after(statement: str) -> set[str]:
    """Top-level modules that a fresh interpreter holds after ``statement``."""
    code = f"{statement}\nimport sys\nprint(*{{name.split('.')[0] for name in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_estimate_leaves_serial_unloaded() -> None:
    assert "serial" not in loaded_after("import motorid.identify")


@pytest.mark.slow
def test_a_fit_begins_without_scipy() -> None:
    """Whose rooms take as long to load as all of the estimator: where it is used, or not at all."""
    assert "scipy" not in loaded_after("import motorid.estimate.selection.entry, motorid.identify")


def test_help_loads_nothing_heavy() -> None:
    statement = (
        "import io, contextlib, motorid.cli.main as m\n"
        "with contextlib.redirect_stdout(io.StringIO()): assert m.run(['--help']) == 0"
    )
    heavy = {"numpy", "scipy", "pandas", "h5py", "serial", "cffi"}
    assert loaded_after(statement) & heavy == set()


def test_the_package_itself_is_light() -> None:
    assert loaded_after("import motorid") & {"numpy", "click"} == set()


POSIX_ONLY = {"fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"}


@pytest.mark.slow
def test_windows_can_import_every_module() -> None:
    """At the top level; inside a function a guard may come first. Only sim/pty is excused."""
    for path in files():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        top = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)]
        modules = {name for node in top for name in names(node)}
        if path.relative_to(PACKAGE).as_posix() != "sim/pty.py":
            assert modules & POSIX_ONLY == set(), path
