"""Databases that run an SQL expression over one table, each by its own reader of it: `ENGINES`.

The table is a Parquet file where the database reads one, since statistics in it decide answers; SQLite and PostgreSQL
get its rows. PostgreSQL is a server that was started before: its program psql finds it by PGHOST, PGPORT and PGUSER.
"""

import csv
import importlib.metadata
import importlib.util
import io
import os
import shutil
import sqlite3
import subprocess
from collections.abc import Callable, Sequence
from contextlib import closing
from datetime import date, datetime
from decimal import Decimal
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

Rows = list[tuple[Any, ...]]
Run = Callable[[Path, Sequence[str]], Rows]
ROW = "row number"
"""The column by which every query is ordered."""
POSTGRES_TYPES = {
    "bool": "boolean",
    "int8": "smallint",
    "int16": "smallint",
    "int32": "integer",
    "int64": "bigint",
    "uint8": "smallint",
    "uint16": "integer",
    "uint32": "bigint",
    "uint64": "numeric",
    "float": "real",
    "double": "double precision",
    "string": "text",
    "date32[day]": "date",
}


def _query(expressions: Sequence[str], source: str) -> str:
    named = ", ".join(f"{one} AS r{k}" for k, one in enumerate(expressions))
    return f'SELECT {named} FROM {source} ORDER BY "{ROW}"'


def run_duckdb(path: Path, expressions: Sequence[str]) -> Rows:
    """Return the answers (n_rows) of expressions over a Parquet file."""
    import duckdb

    with duckdb.connect() as base:
        base.execute("SET TimeZone = 'UTC'")
        return base.execute(_query(expressions, f"'{path}'")).fetchall()


def run_polars(path: Path, expressions: Sequence[str]) -> Rows:
    """See `run_duckdb`."""
    import polars

    context = polars.SQLContext(t=polars.read_parquet(path))
    return context.execute(_query(expressions, "t"), eager=True).rows()


def run_datafusion(path: Path, expressions: Sequence[str]) -> Rows:
    """See `run_duckdb`."""
    import datafusion

    context = datafusion.SessionContext()
    context.register_parquet("t", str(path))
    return _rows(pa.Table.from_batches(context.sql(_query(expressions, "t")).collect()))


def run_clickhouse(path: Path, expressions: Sequence[str]) -> Rows:
    """See `run_duckdb`."""
    import chdb

    settings = "SETTINGS max_query_size = 100000000, output_format_arrow_string_as_string = 1"
    source = f"file('{path}', Parquet)"
    return _rows(chdb.query(f"{_query(expressions, source)} {settings}", "ArrowTable"))


def run_sqlite(path: Path, expressions: Sequence[str]) -> Rows:
    """See `run_duckdb`; dates and times are text there, decimals numbers."""
    table = pq.read_table(path)
    names = ", ".join(_quoted(name) for name in table.column_names)
    with closing(sqlite3.connect(":memory:")) as base:
        base.execute(f"CREATE TABLE t ({names})")
        marks = ", ".join("?" * table.num_columns)
        base.executemany(f"INSERT INTO t VALUES ({marks})", (tuple(map(_for_sqlite, row)) for row in _rows(table)))
        return base.execute(_query(expressions, "t")).fetchall()


def _for_sqlite(cell: Any) -> Any:
    if isinstance(cell, Decimal):
        return float(cell)
    if isinstance(cell, datetime):
        return cell.isoformat("T" if cell.tzinfo else " ")
    return cell.isoformat() if isinstance(cell, date) else cell


def run_postgres(path: Path, expressions: Sequence[str]) -> Rows:
    """See `run_duckdb`; by psql, whose server PGHOST names."""
    table = pq.read_table(path)
    columns = ", ".join(f"{_quoted(field.name)} {_postgres_type(field.type)}" for field in table.schema)
    lines = io.StringIO()
    for row in _rows(table):
        cells = ["\\N" if cell is None else _for_postgres(cell) for cell in row]
        csv.writer(lines, lineterminator="\n").writerow(cells)
    script = (
        f"SET TimeZone = 'UTC'; CREATE TEMP TABLE t ({columns});\n"
        f"COPY t FROM STDIN WITH (FORMAT csv, NULL '\\N');\n{lines.getvalue()}\\.\n"
        f"COPY ({_query(expressions, 't')}) TO STDOUT WITH (FORMAT csv, NULL '\\N', FORCE_QUOTE *);\n"
    )
    command = ["psql", "-X", "-q", "-v", "ON_ERROR_STOP=1", "-d", os.environ.get("PGDATABASE", "postgres")]
    done = subprocess.run(command, input=script, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    return [tuple(None if cell == "\\N" else cell for cell in row) for row in csv.reader(io.StringIO(done.stdout))]


def _postgres_type(kind: pa.DataType) -> str:
    if pa.types.is_dictionary(kind):
        return "text"
    if pa.types.is_decimal(kind):
        return "numeric"
    if pa.types.is_timestamp(kind):
        return "timestamptz" if kind.tz else "timestamp"
    return POSTGRES_TYPES[str(kind)]


def _for_postgres(cell: Any) -> Any:
    return repr(cell) if isinstance(cell, float) else cell


def _rows(table: pa.Table) -> Rows:
    return list(zip(*(column.to_pylist() for column in table.columns), strict=True))


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def _has(package: str) -> Callable[[], str]:
    def version() -> str:
        return importlib.metadata.version(package) if importlib.util.find_spec(package) else ""

    return version


def _postgres() -> str:
    if not (shutil.which("psql") and "PGHOST" in os.environ):
        return ""
    done = subprocess.run(["psql", "-XAtc", "SHOW server_version"], capture_output=True, text=True)
    return done.stdout.partition(" ")[0].strip()


ENGINES: dict[str, tuple[Run, Callable[[], str]]] = {
    "DuckDB": (run_duckdb, _has("duckdb")),
    "Polars": (run_polars, _has("polars")),
    "DataFusion": (run_datafusion, _has("datafusion")),
    "ClickHouse local": (run_clickhouse, _has("chdb")),
    "SQLite": (run_sqlite, lambda: sqlite3.sqlite_version),
    "PostgreSQL": (run_postgres, _postgres),
}
"""How each runs, and its version; "" where it is not there."""


def same(got: Any, expected: Any) -> bool:
    """Whether an answer is the expected one; psql gives texts, SQLite 1 for a Boolean."""
    if got is None or expected is None:
        return got is expected
    if isinstance(got, str) and not isinstance(expected, str):
        return got == ("t" if expected else "f") if isinstance(expected, bool) else float(got) == expected
    return bool(got == expected)
