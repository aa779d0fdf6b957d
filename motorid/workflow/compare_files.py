"""Comparisons into a folder: HTML and CSV, and the runs that make them resumable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from motorid.capture.whole import refuse_existing, write_whole
from motorid.workflow import compare, compare_html, compare_tables, compare_text
from motorid.workflow.tasks import Progress, Workers

RUNS = "runs"  # the folder of finished tasks


def tables_to_files(
    numbers: Sequence[int],
    folder: Path,
    *,
    page: Path | None = None,
    seeds: int | None = None,
    jobs: Workers = -1,
    force: bool = False,
    progress: Callable[[], Progress] | None = None,
) -> list[Path]:
    """Rebuild tables; returns what was written. Raises UsageError where a file exists."""
    wanted = {n: _pair(folder, f"table-{n}") for n in numbers}
    _check(folder, [path for pair in wanted.values() for path in pair], page, force)
    results, written = [], []
    for number, (html, table) in wanted.items():
        result = compare_tables.compare_table(
            number,
            folder / RUNS,
            seeds=seeds or compare_tables.SEEDS,
            jobs=jobs,
            progress=progress() if progress else None,
        )
        write_whole(html, compare_html.table_page(result).encode(), force=force)
        write_whole(table, compare_text.as_csv(result).encode(), force=force)
        written += [html, table]
        results.append(result)
    if page:
        write_whole(page, compare_text.page(results).encode(), force=force)
        written.append(page)
    return written


def captures_to_files(
    paths: Sequence[Path],
    folder: Path,
    *,
    methods: Sequence[str] = (),
    budget: int = compare.BUDGET,
    seeds: int | None = None,
    jobs: Workers = -1,
    truth: Mapping[str, float] | None = None,
    force: bool = False,
    progress: Callable[[], Progress] | None = None,
) -> tuple[str, list[Path]]:
    """Compare methods on captures; the table as text, and what was written."""
    html, table = _pair(folder, "comparison")
    _check(folder, [html, table], None, force)
    result = compare.compare_captures(
        paths,
        folder / RUNS,
        methods=methods or compare.CHOSEN,
        budget=budget,
        seeds=seeds or compare.SEEDS,
        jobs=jobs,
        truth=truth,
        progress=progress() if progress else None,
    )
    write_whole(html, compare_html.comparison_page(result).encode(), force=force)
    write_whole(table, compare_text.comparison_csv(result).encode(), force=force)
    return compare_text.comparison_text(result), [html, table]


def _pair(folder: Path, stem: str) -> tuple[Path, Path]:
    return folder / f"{stem}.html", folder / f"{stem}.csv"


def _check(folder: Path, paths: Sequence[Path], page: Path | None, force: bool) -> None:
    """Before any work: nothing that exists would be replaced without leave."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in [*paths, *([page] if page else [])]:
        refuse_existing(path, force)
