"""Names of captures and of folders: one that says it is another kind of file is refused."""

from __future__ import annotations

from pathlib import Path

from motorid.errors import UsageError

CAPTURE_SUFFIX = ".h5"
OTHERS = {
    "a table": (".csv", ".tsv", ".txt", ".xls", ".xlsx", ".ods", ".parquet", ".feather"),
    "text": (".json", ".jsonl", ".toml", ".yaml", ".yml", ".xml", ".md", ".log", ".ini"),
    "a page or a picture": (".html", ".htm", ".pdf", ".png", ".svg", ".jpg", ".jpeg"),
    "another program's data": (".mat", ".npz", ".npy", ".mcap", ".bag", ".mf4", ".tdms", ".wpilog"),
    "an archive": (".zip", ".gz", ".tar", ".7z"),
    "a history": (".db", ".sqlite"),
    "code": (".py", ".ipynb", ".m", ".hex", ".c", ".sh"),
    "what a run leaves until its capture is whole": (".journal",),
}


def refuse_other_format(path: Path) -> None:
    """Raises UsageError where ``path`` has the suffix of another kind of file.

    A capture is HDF5. Any other name is let pass: M17.2 and run.capture say nothing wrong.
    """
    suffix = path.suffix.lower()
    for kind, suffixes in OTHERS.items():
        if suffix in suffixes:
            raise UsageError(
                f"{path}: a capture is an HDF5 file, and {suffix} says that it is {kind}: "
                f"name it {path.with_suffix(CAPTURE_SUFFIX).name}"
            )


def refuse_file_name(folder: Path) -> None:
    """Raises UsageError where the name of a folder to write says that it is a file."""
    suffix = folder.suffix.lower()
    if suffix == CAPTURE_SUFFIX or any(suffix in suffixes for suffixes in OTHERS.values()):
        raise UsageError(
            f"{folder}: -o names the folder for all that is written, and {suffix} says that it "
            f"is a file: give -o {folder.with_suffix('').name}"
        )
