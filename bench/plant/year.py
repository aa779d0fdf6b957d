"""A year of a plant on PostgreSQL: the results of line_history.py, again and again, by month."""

from __future__ import annotations

from sqlalchemy import Connection, insert, text

from bench import line_history as line
from motorid.quality.history import History
from motorid.quality.history import schema as s
from motorid.quality.history.months import FIRST, make

BLOCK = 20_000  # results that are drawn; the others repeat their values
STAGED = ("results", "captures", "result_captures", "measurements")
OTHER = "substr({}, 1, 56) || lpad(to_hex(:by + {}), 8, '0')"  # a digest of another motor
NUMBER = f"(r.id % {FIRST})"
ID = f"to_char(r.at + :later * interval '1 s', 'YYYYMM')::bigint * {FIRST} + :by + {NUMBER}"
AGAIN = (  # what is staged, :by results and :later seconds on
    f"""INSERT INTO results SELECT {ID}, {OTHER.format("r.key", NUMBER)}, kind,
        'D' || lpad((substr(serial, 2)::bigint + :by)::text, 8, '0'), product, outcome, marginal,
        at + :later * interval '1 s', station, operator, note, versions, limits, estimate
        FROM staged_results r ORDER BY r.id""",
    f"""INSERT INTO result_keys SELECT {OTHER.format("r.key", NUMBER)}, {ID} FROM staged_results r
        ORDER BY r.id""",
    f"""INSERT INTO captures SELECT {OTHER.format("c.sha256", NUMBER)}, path,
        'D' || lpad((substr(c.serial, 2)::bigint + :by)::text, 8, '0'),
        created + :later * interval '1 s', samples, end_reason, rig, program, calibration
        FROM staged_results r JOIN staged_result_captures l ON l.result = r.id
        JOIN staged_captures c ON c.sha256 = l.capture ORDER BY r.id""",
    f"""INSERT INTO result_captures SELECT {ID}, position, {OTHER.format("l.capture", NUMBER)}
        FROM staged_results r JOIN staged_result_captures l ON l.result = r.id ORDER BY r.id""",
    f"""INSERT INTO measurements SELECT {ID}, name, unit, value, uncertainty, low, high,
        guard_band, m.outcome, m.marginal, reason
        FROM staged_results r JOIN staged_measurements m ON m.result = r.id
        ORDER BY r.id, name""",
)


def stage(history: History) -> None:
    """Draws the block, in tables beside the history's."""
    with history.engine.begin() as connection:
        text_ = {"sha256": line.PRODUCT.digest, "text": line.PRODUCT.text}
        connection.execute(insert(s.documents).values(**text_))
        for table in STAGED:
            connection.exec_driver_sql(f"CREATE UNLOGGED TABLE staged_{table} (LIKE {table})")
        for begin in range(1, BLOCK + 1, line.PIECE):
            found = line.rows(begin // line.PIECE, begin, BLOCK, line.PIECE)
            for table in STAGED:
                _copy(connection, f"staged_{table}", found[table])
        connection.exec_driver_sql("ANALYZE")


def _copy(connection: Connection, table: str, rows: list[tuple[object, ...]]) -> None:
    raw = connection.connection.cursor()
    with raw.copy(f"COPY {table} FROM STDIN") as copy:  # type: ignore[attr-defined]
        for row in rows:
            copy.write_row(row)


def repeat(history: History, first: int, last: int) -> None:
    """Adds the results from ``first`` to ``last``, whole blocks; the block's own end is 0."""
    span = line.APART * BLOCK
    for block in range(first // BLOCK, last // BLOCK):
        later = span * block
        with history.engine.begin() as connection:
            for at in (line.UNTIL + later - span, line.UNTIL + later):
                make(connection, at)
        with history.engine.begin() as connection:
            # rows of one transaction cite each other: 44 million checks of that are left out
            connection.exec_driver_sql("SET LOCAL session_replication_role = replica")
            about = {"by": block * BLOCK, "later": later.total_seconds()}
            for one in AGAIN:
                connection.execute(text(one), about)


def analyse(history: History) -> None:
    """As the server's autovacuum does, some minutes later."""
    with history.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
        connection.exec_driver_sql("VACUUM ANALYZE")
