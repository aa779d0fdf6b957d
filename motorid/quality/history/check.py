"""Whether a history in a file is whole: SQLite's own check, and the digests of its texts."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from urllib.parse import quote

from motorid.limits import HISTORY, refuse_large
from motorid.quality.history.records import digest


def damage(path: Path) -> str:
    """What is damaged in the history, in a sentence; "" where nothing is seen.

    Numbers in its rows carry no digest. Raises DataError where it cannot be read at all.
    """
    refuse_large(path, HISTORY)
    try:
        with sqlite3.connect(f"file:{quote(str(path.resolve()))}?mode=ro", uri=True) as connection:
            (said,) = connection.execute("PRAGMA integrity_check(1)").fetchone()
            if said != "ok":
                return str(said).splitlines()[0][:200]
            for sha256, text in connection.execute("SELECT sha256, text FROM documents"):
                if digest(text) != sha256:
                    return f"the text {str(sha256)[:12]} is not what its digest says"
    except (sqlite3.Error, ValueError, TypeError, AttributeError) as error:
        return f"it is no whole history ({error})"
    return ""
