"""What options name, completed by a shell: rigs, products, ports and files."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem


class Name(click.ParamType[str]):
    """A text. A shell completes it by ``known`` names, or where none fits by files."""

    name = "text"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return str(value)

    def known(self) -> Iterable[str]:
        """The names there are."""
        return ()

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        from click.shell_completion import CompletionItem

        names = [name for name in self.known() if name.startswith(incomplete)]
        return [CompletionItem(name) for name in names] or [CompletionItem(incomplete, type="file")]


class RigName(Name):
    """A rig that comes with motorid, or a rig file."""

    def known(self) -> Iterable[str]:
        from motorid.rig_file import presets

        return presets()


class ProductName(Name):
    """A product that comes with motorid, or a product file."""

    def known(self) -> Iterable[str]:
        from motorid.quality.product import presets

        return presets()


class PortName(Name):
    """``auto``, or a serial port that is there; none is opened."""

    def known(self) -> Iterable[str]:
        from motorid.acquire.ports import list_ports

        return ("auto", *(port.device for port in list_ports()))


RIG, PRODUCT, PORT, FILES = RigName(), ProductName(), PortName(), Name()
