"""The table of a fleet is read by those who work with tables: Polars, DuckDB, Spark."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import sesc
from sesc import fleet

from conftest import running


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> tuple[fleet.Fleet, Path]:
    """Three rows, one of a log that is cut."""
    folder = tmp_path_factory.mktemp("logs")
    model = sesc.Robot(sesc.OP2_URDF).on("r_sole")
    for day in (1, 2, 3):
        sesc.simulate(model, 60, range=0.5, noise=1e-4, seed=day).save(folder / f"r0_{day}.csv")
    log = folder / "r0_2.csv"
    log.write_text(log.read_text()[:2000])
    found = fleet.run(sesc.Robot(sesc.OP2_URDF), folder, only="parameters")
    found.save(folder / "fleet.parquet")
    return found, folder / "fleet.parquet"


def read(reader: str, path: Path) -> list[dict[str, Any]]:
    """The rows as a reader of tables has them."""
    module: Any = import_module({"spark": "pyspark.sql"}.get(reader, reader))
    if reader == "polars":
        rows: list[dict[str, Any]] = module.read_parquet(path).to_dicts()
        return rows
    if reader == "duckdb":
        found = module.sql(f"SELECT * FROM '{path}'")
        return [dict(zip(found.columns, row)) for row in found.fetchall()]
    with running("spark") as session:
        return [row.asDict() for row in session.read.parquet(str(path)).collect()]


@pytest.mark.parametrize("reader", ("polars", "duckdb", "spark"))
def test_every_reader_finds_the_same_rows(reader: str, table: tuple[fleet.Fleet, Path]) -> None:
    pytest.importorskip({"spark": "pyspark"}.get(reader, reader))
    found, path = table
    rows = sorted(read(reader, path), key=lambda row: row["day"])
    assert rows == found.rows
    assert [row["error"] is None for row in rows] == [True, False, True]
    assert len(rows[0]["params"]) == len(rows[0]["std"]) == 43
    print(f"{reader} reads the table: {len(rows)} rows")
