"""A shift's verdicts on their way into the history of results, none lost and none twice.

A verdict is on disk in its own folder before it comes here, so a history that cannot be reached
stops no line: the folder keeps no mark, and the next shift makes up for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motorid import json_seal
from motorid.errors import DataError, MotoridError
from motorid.workflow.check import CAPTURE, VERDICT

if TYPE_CHECKING:
    from motorid.quality.product import Product
    from motorid.workflow.check import Inspection

MARK = "in-history"  # in an inspection's folder: the history has it


@dataclass(frozen=True)
class ShiftHistory:
    """``where``: a file, or a database's URL; ``rest``: station, operator (see ResultRecord)."""

    where: str
    product: Product
    rest: Mapping[str, Any]

    def take(self, done: Inspection) -> str:
        """Adds one inspection. What went wrong, in a sentence, or nothing."""
        from motorid.workflow.history import remember_inspection

        try:
            remember_inspection(self.where, done, self.product, **self.rest)
            if done.folder is not None:
                (done.folder / MARK).write_text(f"{self.where}\n", encoding="utf-8")
        except (MotoridError, OSError) as error:
            return f"not in the history yet ({error})"
        return ""

    def catch_up(self, folder: Path) -> str:
        """Adds what an earlier shift could not. What was done and what was not, in a sentence."""
        from motorid.quality.history import open_history
        from motorid.workflow.history import judge_into

        missing = [one for one in sorted(folder.iterdir()) if self._is_missing(one)]
        if not missing:
            return ""
        added = []
        with open_history(self.where) as history:
            for one in missing:
                judged = list(judge_into(history, self.product, [one / CAPTURE], **self.rest))
                if not any(j.failure for j in judged):
                    (one / MARK).write_text(f"{self.where}\n", encoding="utf-8")
                    added.append(one)
        left = len(missing) - len(added)
        said = f"{len(added)} earlier verdicts were added to the history. "
        return said + (f"{left} could not be: see motorid history add. " if left else "")

    def _is_missing(self, one: Path) -> bool:
        """Judged by this very product, with a capture, and not in the history."""
        if (one / MARK).exists() or not ((one / VERDICT).exists() and (one / CAPTURE).exists()):
            return False
        try:
            stored = json_seal.read(one / VERDICT, "a verdict")
        except DataError:
            return False
        versions = stored.get("versions")
        return isinstance(versions, dict) and versions.get("product") == self.product.digest
