"""motorid flash"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example
from motorid.cli.values import Named
from motorid.errors import EXIT_DONE

BOARDS = ("uno", "nano", "mega")


@click.command(
    "flash",
    epilog=example(
        "motorid flash --port /dev/ttyACM0 --board uno",
        "motorid flash --port COM3 --board mega --hex motorid-mega.hex --dry-run",
    ),
)
@click.option("--port", required=True, help="The board's serial device; motorid ports lists them.")
@click.option("--board", required=True, type=click.Choice(BOARDS), help="Which board it is.")
@click.option(
    "--hex",
    "hex_file",
    type=Named(dir_okay=False, path_type=Path),
    help="Firmware file; without it, the one that came with motorid or was built here.",
)
@click.option("--dry-run", is_flag=True, help="Show avrdude's commands, and do nothing.")
def command(port: str, board: str, hex_file: Path | None, dry_run: bool) -> int | None:
    """Put motorid's firmware on an Arduino Uno, Nano or Mega, by avrdude.

    The file is checked first: it must be motorid's firmware, and for that board. A port that a
    capture holds is refused, and while avrdude works no capture can open it. A Nano takes the Uno's
    firmware, and is tried with its old bootloader and with its new one. Switch the motor's
    supply off meanwhile: pull-downs keep the bridge open through the bootloader, if they are there.
    """
    import shlex

    from motorid.workflow import flash

    path = hex_file or flash.firmware_file(board)
    if dry_run:
        flash.check_firmware(path, board)
        for words in flash.commands(port, board, path):
            click.echo(shlex.join(words))
        return None
    click.echo(f"flashing {path} ...", err=True)
    click.echo(flash.flash(port, board, path))
    return EXIT_DONE
