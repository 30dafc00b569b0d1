"""SQL over the results of a study, by DuckDB: reading only, and only what is in the folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import duckdb
import pyarrow as pa

from ridedown.errors import InvalidInput
from ridedown.studies.results.store import chunk_files, read_manifest

_QUOTE = 'Put a name with dots in double quotes: SELECT max("adult.excursion.max") FROM results.'


def query(folder: Path, sql: str) -> pa.Table:
    """What a single SELECT says of the results in a folder.

    Views: `results`, a row for each crash or set of crashes with its inputs, outcomes, `status` and `why`; `columns`, the
    names of inputs and outcomes with their SI units.

    Raises: InvalidInput for a folder without results, or SQL that is wrong or would do more than read.
    """
    connection = connect(folder)
    try:
        statements = connection.extract_statements(sql)
    except duckdb.Error as error:
        raise _refused(error) from None
    if len(statements) != 1:
        raise InvalidInput(f"SQL: got {len(statements)} statements; need one SELECT. Run them one by one.")
    if statements[0].type != duckdb.StatementType.SELECT:
        word = statements[0].type.name
        raise InvalidInput(f"SQL: got {word}; need a SELECT. Results are only read; send the output to a file to keep it.")
    try:
        return connection.sql(sql).to_arrow_table()
    except duckdb.Error as error:
        raise _refused(error) from None


def connect(folder: Path) -> duckdb.DuckDBPyConnection:
    """A connection with the views `results` and `columns`, that reads the folder and nothing else.

    Raises: InvalidInput for a folder without results.
    """
    manifest = read_manifest(folder)
    files = [str(path.resolve()) for path in chunk_files(folder)]
    if not files:
        raise InvalidInput(f"{folder}: got a study with no chunk done yet; need one or more. Go on with it by --resume.")
    connection = duckdb.connect(":memory:")
    connection.execute("SET TimeZone = 'UTC'")
    allowed = str((folder / "chunks").resolve()).replace("'", "''")
    connection.execute(f"SET allowed_directories = ['{allowed}/']")
    connection.execute("SET enable_external_access = false")
    connection.execute("SET lock_configuration = true")
    listed = ", ".join("'" + file.replace("'", "''") + "'" for file in files)
    connection.execute(f"CREATE VIEW results AS SELECT * FROM read_parquet([{listed}])")
    connection.execute("CREATE TABLE columns (name VARCHAR, unit VARCHAR, role VARCHAR)")
    rows = [(column["name"], column["unit"], column["role"]) for column in manifest["columns"]]
    connection.executemany("INSERT INTO columns VALUES (?, ?, ?)", rows)
    return connection


def _refused(error: duckdb.Error) -> InvalidInput:
    lines = [line.strip() for line in str(error).splitlines() if line.strip() and not set(line.strip()) <= {"^"}]
    said = " ".join(line for line in lines if not line.startswith("LINE ")).rstrip(".")
    end = "" if said.endswith("?") else "."
    return InvalidInput(f"SQL: {said}{end}" + (f" {_QUOTE}" if isinstance(error, duckdb.BinderException) else ""))


def rows_of(table: pa.Table) -> list[dict[str, Any]]:
    """The rows of a table as plain data."""
    rows: list[dict[str, Any]] = table.to_pylist()
    return rows
