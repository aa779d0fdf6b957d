"""motorid flash"""

from __future__ import annotations

from pathlib import Path

import click

from motorid.cli.options import example
from motorid.cli.values import Named
from motorid.errors import EXIT_DONE, UsageError

BOARDS = ("uno", "nano", "mega", "pico")


@click.command(
    "flash",
    epilog=example(
        "motorid flash --port /dev/ttyACM0 --board uno",
        "motorid flash --port COM3 --board mega --hex motorid-mega.hex --dry-run",
        "motorid flash --board pico",
    ),
)
@click.option("--port", help="The board's serial device; motorid ports lists them.")
@click.option("--board", required=True, type=click.Choice(BOARDS), help="Which board it is.")
@click.option(
    "--hex",
    "file",
    type=Named(dir_okay=False, path_type=Path),
    help="Firmware file; without it, the one that came along or was built here.",
)
@click.option(
    "--drive",
    type=Named(file_okay=False, path_type=Path),
    help="Folder of a Pico's boot drive; without it, the only one that is mounted.",
)
@click.option("--dry-run", is_flag=True, help="Show what would be done, and do nothing.")
def command(
    port: str | None, board: str, file: Path | None, drive: Path | None, dry_run: bool
) -> int | None:
    """Put motorid's firmware on an Arduino Uno, Nano or Mega, or on a Raspberry Pi Pico.

    The file is checked first: it must be motorid's firmware, and for that board. Arduinos take
    it by avrdude. A port that a capture holds is refused, and while avrdude works no capture can
    open it. A Nano takes the Uno's firmware, and is tried with its old bootloader and its new one.

    A Pico takes the file from a drive, which it shows when its button BOOTSEL is held while USB is
    connected. With --port, its serial port once it runs, the board is then asked who it is.

    Switch the motor's supply off meanwhile: pull-downs keep the bridge open through the bootloader,
    if they are there.
    """
    from motorid.workflow import flash

    path = file or flash.firmware_file(board)
    if board == flash.PICO:
        return _to_drive(path, drive, port, dry_run)
    if drive is not None:
        raise UsageError(f"--drive is for the board pico: the {board} is flashed over its --port")
    if port is None:
        raise UsageError(f"--port is missing: the {board} is flashed over it; see motorid ports")
    return _by_avrdude(path, port, board, dry_run)


def _by_avrdude(path: Path, port: str, board: str, dry_run: bool) -> int | None:
    import shlex

    from motorid.workflow import flash

    if dry_run:
        flash.check_firmware(path, board)
        for words in flash.commands(port, board, path):
            click.echo(shlex.join(words))
        return None
    click.echo(f"flashing {path} ...", err=True)
    click.echo(flash.flash(port, board, path))
    return EXIT_DONE


def _to_drive(path: Path, drive: Path | None, port: str | None, dry_run: bool) -> int | None:
    import shlex

    from motorid.workflow import flash_drive

    if dry_run:
        flash_drive.check_firmware(path)
        click.echo(shlex.join(["cp", str(path), str(flash_drive.target(path, drive))]))
        return None
    click.echo(f"flashing {path} ...", err=True)
    click.echo(f"copied to {flash_drive.flash(path, drive)}: the Pico restarts by itself")
    if port is not None:
        click.echo(flash_drive.await_board(port))
    return EXIT_DONE
