"""motorid verify"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from motorid.cli.options import example
from motorid.cli.values import Kept
from motorid.errors import EXIT_DATA, EXIT_DONE
from motorid.visible import on_one_line

if TYPE_CHECKING:
    from motorid.storage.place import File
    from motorid.workflow.verify import Finding


@click.command("verify", epilog=example("motorid verify m17.h5 m17", "motorid verify --json line"))
@click.argument("paths", nargs=-1, required=True, type=Kept(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def command(paths: tuple[File, ...], as_json: bool) -> int:
    """Say of each file whether it is still what was written.

    A capture, an estimate and a verdict carry the SHA-256 of their content, a journal one of its
    records, the index of a pack one of each file in it. A folder is searched for such files, with
    its folders; captures and packs may be in an object store. One line a file: sound, carries no
    digest (older files), cut short (a journal's end is missing) or damaged, and where.

    Exit codes: 0, 4 where a file is damaged, 2 where a path is not there.
    """
    from motorid import json_text
    from motorid.errors import DataError
    from motorid.workflow.verify import DAMAGED, as_data, verify

    findings = []
    for one in verify(paths):
        findings.append(one)
        if not as_json:
            click.echo(_line(one))
    if as_json:
        click.echo(json_text.dumps(as_data(findings), indent=2))
    if not findings:
        raise DataError(f"{paths[0]} holds no file that motorid writes: name another folder")
    return EXIT_DATA if any(one.state == DAMAGED for one in findings) else EXIT_DONE


def _line(one: Finding) -> str:
    where = f": {one.where}" if one.where else ""
    return on_one_line(f"{one.state:<17} {one.path}{where}")
