"""motorid config"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from motorid.cli.options import example
from motorid.errors import UsageError


@click.command(
    "config",
    epilog=example(
        "motorid config",
        "motorid config rig bench.toml",
        "motorid config port auto",
        "motorid config --unset port",
    ),
)
@click.argument("key", required=False)
@click.argument("value", required=False)
@click.option("--unset", is_flag=True, help="Forget the default KEY.")
def command(key: str | None, value: str | None, unset: bool) -> None:
    """Show the defaults of options, or set KEY to VALUE for each later command.

    What is typed goes before what is set. A capture records what it took from here. Limits,
    calibration and gains are not set here: they belong to the rig file. The file is
    config.toml in the folder of your settings, or what MOTORID_CONFIG names.
    """
    from motorid.cli import settings

    found = settings.read()
    if key is None:
        _show(found)
        return
    if unset == (value is not None):
        raise click.UsageError("give a VALUE, or --unset: one of the two.")
    if unset:
        settings.check(
            key, settings.SETTINGS[key].kind("1") if key in settings.SETTINGS else "", "config"
        )
        found.pop(key, None)
    else:
        given = _value(key, str(value))
        settings.check(key, given, "config")
        found[key] = given
    click.echo(f"wrote {settings.write(found)}", err=True)
    _show(found)


def _value(key: str, text: str) -> Any:
    """``text`` as ``key`` takes it. A file that is there is named from the root, for any folder."""
    from motorid.cli.settings import SETTINGS

    if key in SETTINGS and SETTINGS[key].kind is int:
        try:
            return int(text)
        except ValueError:
            raise UsageError(f"config: {key} is to be a whole number, not {text!r}") from None
    is_file = key in ("rig", "product", "history") and "://" not in text and Path(text).is_file()
    return str(Path(text).resolve()) if is_file else text


def _show(found: dict[str, Any]) -> None:
    from motorid.cli.settings import SETTINGS, place

    click.echo(f"# {place()}")
    for key, one in SETTINGS.items():
        if key in found:
            click.echo(f"{key} = {found[key]!r}")
        else:
            click.echo(f"# {key}: {one.meaning} ({', '.join(one.commands)})")
