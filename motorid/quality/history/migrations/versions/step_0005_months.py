"""On PostgreSQL: a partition for each month, made by who adds its first result; see months.py.

Results that are there keep their ids, which their seals cover, in the partitions ``*_before``.
Other databases stay as they are.
"""

from __future__ import annotations

from string import Template

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"

FIRST = 10**10
LOCK = 0x6D6F6E74
KEYS = {
    "results": ("id",),
    "measurements": ("result", "name"),
    "result_captures": ("result", "position"),
}
CITES = {
    "results": (("limits", "documents (sha256)"), ("estimate", "documents (sha256)")),
    "measurements": (("result", "results (id)"),),
    "result_captures": (("result", "results (id)"), ("capture", "captures (sha256)")),
}
INDICES = {
    "results": {
        **{f"ix_results_{one}": one for one in ("serial", "at")},
        **{f"ix_results_{one}_id": f"{one}, id" for one in ("outcome", "station", "product")},
    },
    "measurements": {"ix_measurements_name_result": "name, result"},
    "result_captures": {"ix_result_captures_capture": "capture"},
}
WIDER = """
    ALTER TABLE measurements DROP CONSTRAINT fk_measurements_result;
    ALTER TABLE result_captures DROP CONSTRAINT fk_result_captures_result;
    ALTER TABLE results ALTER id TYPE bigint;
    ALTER TABLE measurements ALTER result TYPE bigint;
    ALTER TABLE result_captures ALTER result TYPE bigint;
    ALTER TABLE seals ALTER result TYPE bigint;
    ALTER SEQUENCE results_id_seq AS bigint MAXVALUE 9999999999;
    ALTER TABLE results DROP CONSTRAINT uq_results_key
"""
UNIQUE = """
    CREATE TABLE result_keys (
        key varchar(64) NOT NULL CONSTRAINT pk_result_keys PRIMARY KEY,
        result bigint NOT NULL CONSTRAINT fk_result_keys_result REFERENCES results (id)
    );
    INSERT INTO result_keys SELECT key, id FROM results
"""
# With the rights of the tables' owner: a station may add rows, and make no tables.
MONTH = """
CREATE FUNCTION motorid_month(month integer) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = $schema, pg_temp AS $$$$
DECLARE
    whole text;
    part text;
BEGIN
    IF month NOT BETWEEN 101 AND 999912 OR month % 100 NOT BETWEEN 1 AND 12 THEN
        RAISE EXCEPTION '% is no month', month;
    END IF;
    PERFORM pg_advisory_xact_lock($lock);
    FOREACH whole IN ARRAY ARRAY['results', 'measurements', 'result_captures'] LOOP
        part := format('%s_%s', whole, month);
        -- to_regclass may answer from before the lock: it reads the session's own cache
        IF NOT EXISTS (SELECT FROM pg_tables
                WHERE schemaname = current_schema() AND tablename = part) THEN
            EXECUTE format('CREATE TABLE %I (LIKE %I INCLUDING DEFAULTS)', part, whole);
            EXECUTE format('ALTER TABLE %I ATTACH PARTITION %I FOR VALUES FROM (%s) TO (%s)',
                whole, part, month * $first, (month + 1) * $first);
        END IF;
    END LOOP;
END $$$$
"""


def upgrade() -> None:
    """Divides the three tables that hold a row or more of each result."""
    connection = op.get_bind()
    if connection.dialect.name != "postgresql":
        return
    _run(WIDER)
    there = connection.scalar(sa.text("SELECT count(*) FROM (SELECT FROM results LIMIT 1) AS one"))
    for table in KEYS:
        _divide(table, bool(there))
    _run(UNIQUE)
    here = str(connection.scalar(sa.text("SELECT current_schema()")))
    schema = connection.dialect.identifier_preparer.quote(here)
    made = Template(MONTH).substitute(schema=schema, lock=LOCK, first=FIRST)
    connection.exec_driver_sql(made.replace("%", "%%"))
    _run("REVOKE ALL ON FUNCTION motorid_month(integer) FROM PUBLIC")


def _divide(table: str, kept: bool) -> None:
    """Makes ``table`` one of partitions; what it holds becomes the first of them."""
    old, key = f"{table}_before", KEYS[table]
    _run(f"ALTER TABLE {table} RENAME TO {old}")
    for name in (f"pk_{table}", *INDICES[table]):
        _run(f"ALTER INDEX {name} RENAME TO {name.replace(table, old)}")
    _run(f"CREATE TABLE {table} (LIKE {old} INCLUDING DEFAULTS) PARTITION BY RANGE ({key[0]})")
    _run(f"ALTER TABLE {table} ADD CONSTRAINT pk_{table} PRIMARY KEY ({', '.join(key)})")
    for column, cited in CITES[table]:
        constraint = f"fk_{table}_{column}"
        _run(f"ALTER TABLE {table} ADD CONSTRAINT {constraint} "
             f"FOREIGN KEY ({column}) REFERENCES {cited}")  # fmt: skip
    for name, columns in INDICES[table].items():
        _run(f"CREATE INDEX {name} ON {table} ({columns})")
    if table == "results":
        _run("ALTER SEQUENCE results_id_seq OWNED BY results.id")
    if kept:
        bounds = f"FROM (MINVALUE) TO ({FIRST})"
        _run(f"ALTER TABLE {table} ATTACH PARTITION {old} FOR VALUES {bounds}")
    else:
        _run(f"DROP TABLE {old}")


def _run(statements: str) -> None:
    for one in statements.split(";"):
        op.get_bind().exec_driver_sql(one)
