"""Logs in every form are the same log; what is wrong with one is said."""

from __future__ import annotations

import gzip
import io
import math
import pickle
import re
from datetime import timezone
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import POLE
from recording import record

N = 60


@pytest.fixture(scope="module")
def pole() -> sesc.Robot:
    return sesc.Robot(POLE)


@pytest.fixture(scope="module")
def columns() -> dict[str, Any]:
    """The pole's CoM is 1.05 m along it; noise of 0.1 mm by two sines."""
    k = np.arange(N)
    hip = 0.6 * np.sin(0.7 * k)
    return {
        "pose": k,
        "hip": hip,
        "cop_x": 0.1 + 1.05 * np.sin(hip) + 1e-4 * np.sin(7.1 * k),
        "cop_y": 1e-4 * np.sin(3.3 * k),
    }


def csv_of(columns: dict[str, Any]) -> str:
    rows = zip(*(map(repr, np.asarray(column).tolist()) for column in columns.values()))
    return "\n".join([",".join(columns), *(",".join(row) for row in rows)]) + "\n"


def params(robot: sesc.Robot, log: Any) -> list[float]:
    log = log if isinstance(log, sesc.Log) else sesc.Log(log, support="foot")
    return [float(x) for x in sesc.fit(robot, log, noise=1e-4).params]


def test_a_fit_finds_the_true_length(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    found = sesc.fit(pole, sesc.Log(columns, support="foot"), noise=1e-4)
    moved = [p for p in found.parameters.values() if abs(p.cad - 1.0) < 1e-9]
    assert len(moved) == 1 and moved[0].std is not None
    assert abs(moved[0].value - 1.05) < 4 * moved[0].std < 1e-3
    k = list(found.parameters).index(moved[0].name)
    assert found.params[k] == moved[0].value
    assert math.sqrt(found.covariance[k, k]) == pytest.approx(moved[0].std, rel=0.2)
    assert found.postures == N and found.noise_floor == pytest.approx(1e-4, rel=1e-6)
    assert found.held_out_rmse < 2e-4 and found.unobservable and isinstance(found.warnings, list)
    assert found.rank == found.to_dict()["rank"]
    np.testing.assert_array_equal(found.model.params, found.params)


def test_every_form_is_the_same_log(pole: sesc.Robot, columns: dict[str, Any], tmp_path: Path) -> None:
    want = params(pole, columns)
    text = csv_of(columns)
    (tmp_path / "log.csv").write_text(text)
    (tmp_path / "log.csv.gz").write_bytes(gzip.compress(text.encode()))
    (tmp_path / "strange").write_text(text)
    strided = {name: np.repeat(column, 3)[::3] for name, column in columns.items()}
    lists = {name: column.tolist() for name, column in columns.items()}
    forms = [tmp_path / "log.csv", str(tmp_path / "log.csv.gz"), text.encode(), io.StringIO(text)]
    forms += [io.BytesIO(text.encode()), tmp_path / "strange", strided, lists]
    for form in forms:
        assert params(pole, form) == want, form


@pytest.mark.parametrize("kind", ["arrow", "arrow_chunked", "polars", "pandas", "duckdb"])
def test_tables_of_others_are_the_same_log(
    pole: sesc.Robot, columns: dict[str, Any], kind: str, tmp_path: Path
) -> None:
    want = params(pole, columns)
    if kind.startswith("arrow"):
        pa = pytest.importorskip("pyarrow")
        table: Any = pa.table(columns)
        if kind == "arrow_chunked":
            table = pa.concat_tables([table.slice(0, 7), table.slice(7, 20), table.slice(27)])
            table = table.append_column("support", pa.array(["foot"] * N).dictionary_encode())
    elif kind == "polars":
        table = pytest.importorskip("polars").DataFrame(columns)
        with pytest.raises(TypeError, match="collect"):
            sesc.Log(table.lazy())
    elif kind == "pandas":
        table = pytest.importorskip("pandas").DataFrame(columns)
    else:
        duckdb = pytest.importorskip("duckdb")
        (tmp_path / "log.csv").write_text(csv_of(columns))
        table = duckdb.read_csv(str(tmp_path / "log.csv"))
    assert params(pole, table) == want


def test_arrow_types_become_numbers(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    pa = pytest.importorskip("pyarrow")
    table = {
        "pose": pa.array(columns["pose"], pa.int16()),
        "hip": pa.array(columns["hip"].astype(np.float32)),
        "t": pa.array([1000 * k for k in range(N)], pa.timestamp("ms")),
        "flag": pa.array([True, None, False] * (N // 3)),
        "cop_x": pa.array([None, *columns["cop_x"][1:].tolist()], pa.float64()),
        "cop_y": pa.array(columns["cop_y"]),
        "support": pa.array(["foot"] * N, pa.string_view()),
        "note": pa.array(["a text that is longer than twelve bytes", None] * (N // 2), pa.string_view()),
    }
    log = sesc.Log(pa.table(table).slice(0, N))
    got = log.columns()
    assert got["t"].tolist() == [float(k) for k in range(N)]
    assert np.isnan(got["cop_x"][0]) and got["cop_x"][1] == columns["cop_x"][1]
    assert got["hip"].dtype == np.float64 and got["pose"].dtype == np.int64
    assert got["support"] == ["foot"] * N and got["note"][:2] == ["a text that is longer than twelve bytes", ""]
    assert got["flag"][0] == 1.0 and np.isnan(got["flag"][1]) and got["flag"][2] == 0.0


def odd_columns(pa: Any) -> dict[str, Any]:
    """Columns that are neither numbers nor text, by what they are said to hold."""
    half = N // 2
    return {
        "dates": pa.array([1] * N, pa.date32()),
        "times of day": pa.array([1] * N, pa.time32("s")),
        "lists": pa.array([[1, 2], None] * half, pa.list_(pa.int8())),
        "structures": pa.array([{"a": 1}] * N),
        "bytes": pa.array([b"x"] * N, pa.binary()),
        "maps": pa.array([[("a", 1)]] * N, pa.map_(pa.string(), pa.int8())),
        "lists (Arrow format +w:2)": pa.array([[1.0, 2.0]] * N, pa.list_(pa.float64(), 2)),
        "intervals": pa.array([None] * N, pa.month_day_nano_interval()),
    }


def test_columns_that_nobody_uses_may_hold_anything(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    pa = pytest.importorskip("pyarrow")
    want = params(pole, columns)
    for what, odd in odd_columns(pa).items():
        assert params(pole, pa.table({**columns, "note": odd})) == want, what
        used = sesc.Log(pa.table({**columns, "hip": odd}), support="foot")
        with pytest.raises(sesc.LogError, match=re.escape(f"column `hip` holds {what}")) as caught:
            sesc.fit(pole, used)
        assert "cast them to numbers" in str(caught.value)
    assert params(pole, {**columns, "note": np.zeros(N, complex)}) == want
    with pytest.raises(sesc.LogError, match="column `hip` holds values of the type complex128; cast"):
        sesc.fit(pole, sesc.Log({**columns, "hip": np.zeros(N, complex)}, support="foot"))
    pandas = pytest.importorskip("pandas")
    for values in ([[1, 2]] * N, [{"a": 1}] * N, [b"x"] * N, pandas.period_range("2026", periods=N)):
        assert params(pole, pandas.DataFrame({**columns, "note": values})) == want


def test_decimals_halves_and_dictionaries_are_numbers() -> None:
    pa = pytest.importorskip("pyarrow")
    want = [-1.25, 0.5, None, 3.0]
    texts = ["-1.25", "0.5", None, "3"]
    kinds = [pa.decimal128(9, 4), pa.decimal256(40, 4)]
    arrays = [pa.array([None if x is None else Decimal(x) for x in texts], kind) for kind in kinds]
    arrays.append(pa.array([None if x is None else np.float16(x) for x in want], pa.float16()))
    arrays.append(pa.array(want).dictionary_encode())
    for array in arrays:
        kept = sesc.Log(pa.table({"hip": array})).columns()
        np.testing.assert_array_equal(kept["hip"], [np.nan if x is None else x for x in want])
    nothing = sesc.Log(pa.table({"hip": pa.nulls(4)})).columns()
    assert np.isnan(nothing["hip"]).all()


@pytest.mark.parametrize("kind", ["s", "ms", "us", "ns", "zone", "int96"])
def test_times_of_parquet_are_those_of_its_table(
    pole: sesc.Robot, columns: dict[str, Any], kind: str, tmp_path: Path
) -> None:
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    unit = {"zone": "us", "int96": "ns"}.get(kind, kind)
    since = (1772352000 + 2 * np.arange(N)) * {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
    typed = pa.timestamp(unit, tz="Europe/Paris" if kind == "zone" else None)
    table = pa.table({**columns, "t": pa.array(since, typed)})
    parquet.write_table(table, tmp_path / "log.parquet", use_deprecated_int96_timestamps=kind == "int96")
    logs = [sesc.Log(log, support="foot") for log in (table, tmp_path / "log.parquet")]
    found = [sesc.fit(pole, log, noise=1e-4) for log in logs]
    assert found[0].params.tolist() == found[1].params.tolist()
    times = [one.to_dict()["data"][0]["times"] for one in found]
    assert times == [[1772352000.0, 1772352000.0 + 2 * (N - 1)]] * 2


def test_an_arrow_stream_that_was_taken_is_refused(columns: dict[str, Any]) -> None:
    pa = pytest.importorskip("pyarrow")

    class Taken:
        def __arrow_c_stream__(self, requested_schema: object = None) -> object:
            capsule = pa.table(columns).__arrow_c_stream__()
            pa.RecordBatchReader._import_from_c_capsule(capsule)
            return capsule

    with pytest.raises(ValueError, match="the Arrow stream was released"):
        sesc.Log(Taken())


def test_parquet_of_others_is_read(pole: sesc.Robot, columns: dict[str, Any], tmp_path: Path) -> None:
    pa = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    for packing in ("zstd", "snappy", "none"):
        parquet.write_table(pa.table(columns), tmp_path / "log.parquet", compression=packing)
        assert params(pole, tmp_path / "log.parquet") == params(pole, columns)


def test_settings_win_over_the_sidecar(pole: sesc.Robot, columns: dict[str, Any], tmp_path: Path) -> None:
    turned = {**columns, "hip": np.rad2deg(columns["hip"])}
    (tmp_path / "log.csv").write_text(csv_of(turned))
    (tmp_path / "log.csv.toml").write_text("support = 'top'\nangles = 'rad'\n")
    log = sesc.Log(tmp_path / "log.csv", support="foot", angles="deg")
    assert log.settings["support"] == "foot" and log.settings["angles"] == "deg"
    np.testing.assert_allclose(params(pole, log), params(pole, columns), atol=1e-12)
    for wrong in ({"angles": "turns"}, {"cells": [[0, 0], [9, 9]]}, {"gravity": [0, 0, 9.8]}):
        with pytest.raises(sesc.LogError):
            sesc.Log(tmp_path / "log.csv", **wrong)


def test_columns_are_renamed(pole: sesc.Robot, columns: dict[str, Any], tmp_path: Path) -> None:
    other = {{"hip": "q_hip", "cop_x": "x"}.get(name, name): column for name, column in columns.items()}
    (tmp_path / "log.csv").write_text(csv_of(other))
    names = {"q_hip": "hip", "x": "cop_x"}
    for form in (other, tmp_path / "log.csv"):
        assert params(pole, sesc.Log(form, support="foot", columns=names)) == params(pole, columns)
    with pytest.raises(sesc.LogError, match="`hips`"):
        params(pole, sesc.Log(other, support="foot", columns={**names, "hips": "t"}))


def test_columns_that_have_the_name_of_a_joint_in_theirs_are_asked_about(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    other = {f"/joint_states/{name}.position [rad]" if name == "hip" else name: column for name, column in columns.items()}
    with pytest.raises(sesc.LogError) as caught:
        params(pole, other)
    said = "if these columns are positions of joints, give `columns=` these pairs:"
    assert f'{said} {{ "/joint_states/hip.position [rad]" = "hip" }}' in str(caught.value)


def test_all_rows_with_faults_are_named_at_once(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    for rows, words in (([3, 7, 9], "; rows 8, 10 are faulty, too"), ([3, 7], "; row 8 is faulty, too"), (range(3, 23), "16 and 7 more are faulty, too")):
        x = columns["cop_x"].copy()
        x[list(rows)] = 1e300
        with pytest.raises(sesc.LogError) as caught:
            params(pole, {**columns, "cop_x": x})
        assert ":4: column `cop_x`" in str(caught.value) and words in str(caught.value), caught.value


def test_faults_have_file_line_and_column(pole: sesc.Robot, columns: dict[str, Any], tmp_path: Path) -> None:
    lines = csv_of(columns).splitlines()
    lines[3] = lines[3].replace(lines[3].split(",")[1], "two")
    (tmp_path / "log.csv").write_text("\n".join(lines))
    with pytest.raises(sesc.LogError) as caught:
        params(pole, tmp_path / "log.csv")
    error = caught.value
    assert (error.file, error.line, error.column) == (str(tmp_path / "log.csv"), 4, "hip")
    with pytest.raises(FileNotFoundError) as missing:
        sesc.Log(tmp_path / "none.csv")
    assert isinstance(missing.value, sesc.LogError)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"hip": None}, "hip"),
        ({"cop_x": None}, "cop_x"),
        ({"hip": np.zeros(3)}, "rows"),
        ({"hip": ["a"] * N}, "numbers"),
        ({"pose": np.arange(N) + 0.5}, "pose"),
        ({"support": ["foot", "fot"] * (N // 2)}, "fot"),
        ({"hip": np.full(N, np.inf)}, "hip"),
    ],
)
def test_tables_with_faults_are_refused(
    pole: sesc.Robot, columns: dict[str, Any], change: dict[str, Any], words: str, capfd: Any
) -> None:
    table = {name: column for name, column in {**columns, **change}.items() if column is not None}
    with pytest.raises(sesc.LogError, match=words) as caught:
        params(pole, table)
    assert not re.search(r"(^|[\s`(])--[a-z]", str(caught.value))
    assert capfd.readouterr() == ("", "")


def test_truncated_files_are_errors(pole: sesc.Robot, columns: dict[str, Any], tmp_path: Path, capfd: Any) -> None:
    pa = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    parquet.write_table(pa.table(columns), tmp_path / "log.parquet")
    whole = (tmp_path / "log.parquet").read_bytes()
    for cut in range(0, len(whole), 61):
        with pytest.raises(sesc.SescError):
            params(pole, sesc.Log(whole[:cut], support="foot", name="log.parquet"))
        damaged = bytearray(whole)
        damaged[cut] ^= 0xFF
        try:
            params(pole, sesc.Log(bytes(damaged), support="foot", name="log.parquet"))
        except sesc.SescError:
            pass
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", ["parquet", "mcap"])
def test_logs_cut_at_any_byte_are_errors(kind: str, tmp_path: Path, capfd: Any) -> None:
    """A small file, cut at every length, is refused: nothing is fitted to half of a log."""
    robot, whole = small_file(kind, tmp_path)
    name = f"log.{kind}"
    assert sesc.gather(robot, sesc.Log(whole, support="foot", name=name)).postures >= 3
    for cut in range(len(whole)):
        with pytest.raises(sesc.SescError) as caught:
            sesc.gather(robot, sesc.Log(whole[:cut], support="foot", name=name))
        assert name in str(caught.value), cut
    assert capfd.readouterr() == ("", "")


def small_file(kind: str, folder: Path) -> tuple[sesc.Robot, bytes]:
    if kind == "mcap":
        model = sesc.Robot(POLE).on("foot")
        record(folder / "log.mcap", sesc.simulate(model, 3, noise=1e-4), model, rate=10.0)
        return model.robot, (folder / "log.mcap").read_bytes()
    pa: Any = pytest.importorskip("pyarrow")
    parquet: Any = pytest.importorskip("pyarrow.parquet")
    hip = np.linspace(-0.5, 0.5, 8)
    file = io.BytesIO()
    table = pa.table({"hip": hip, "cop_x": 0.1 + np.sin(hip), "cop_y": np.cos(40 * hip) * 1e-4})
    parquet.write_table(table, file, store_schema=False)
    return sesc.Robot(POLE), file.getvalue()


@pytest.mark.parametrize("unit", ["ns", "us", "ms"])
def test_times_of_every_kind_are_seconds(columns: dict[str, Any], unit: str) -> None:
    pandas = pytest.importorskip("pandas")
    seconds = 0.25 * np.arange(N)
    factor = {"ns": 10**9, "us": 10**6, "ms": 10**3}[unit]
    since = (seconds * factor).astype("int64").astype(f"timedelta64[{unit}]")
    dates = np.array("2026-03-01T08:00", dtype=f"datetime64[{unit}]") + since
    forms: list[Any] = [since, dates, pandas.Series(since), pandas.Series(dates)]
    for form, first in zip(forms, (0.0, 1772352000.0, 0.0, 1772352000.0), strict=True):
        for table in ({**columns, "t": form}, pandas.DataFrame({**columns, "t": form})):
            kept = sesc.Log(table, support="foot").columns()
            assert kept is not None
            np.testing.assert_allclose(kept["t"], first + seconds, rtol=1e-15, atol=1e-12)


def test_times_are_the_same_from_every_table(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    pandas, polars, pyarrow = map(pytest.importorskip, ("pandas", "polars", "pyarrow"))
    dates = np.array("2026-03-01T08:00", dtype="datetime64[us]") + (250_000 * np.arange(N)).astype("timedelta64[us]")
    table = {**columns, "t": dates}
    zoned = pandas.DataFrame(table)
    zoned["t"] = zoned["t"].dt.tz_localize("UTC").dt.tz_convert("Europe/Paris")
    listed = {**columns, "t": [x.replace(tzinfo=timezone.utc) for x in dates.tolist()]}
    forms = [table, pandas.DataFrame(table), zoned, listed, polars.DataFrame(table), pyarrow.table(table)]
    parts = {bytes(sesc.gather(pole, sesc.Log(form, support="foot"))) for form in forms}
    assert len(parts) == 1


def test_masked_values_are_no_numbers(columns: dict[str, Any]) -> None:
    masked = np.ma.masked_array(columns["hip"], mask=[True] + [False] * (N - 1))
    kept = sesc.Log({**columns, "hip": masked}, support="foot").columns()
    assert kept is not None and np.isnan(kept["hip"][0]) and not np.isnan(kept["hip"][1:]).any()


def test_progress_without_a_console(pole: sesc.Robot, columns: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdout", None)
    sesc.fit(pole, sesc.Log(columns, support="foot"), progress=True)


def test_a_time_that_is_missing_is_no_number(columns: dict[str, Any]) -> None:
    for kind in ("timedelta64[ms]", "datetime64[ms]"):
        times = np.arange(N).astype(kind)
        times[0] = np.array("NaT", dtype=kind)
        kept = sesc.Log({**columns, "t": times}, support="foot").columns()
        assert kept is not None and np.isnan(kept["t"][0])
        assert np.diff(kept["t"][1:]) == pytest.approx(1e-3)
        times[:] = times[0]
        nothing = sesc.Log({**columns, "t": times}, support="foot").columns()
        assert nothing is not None and np.isnan(nothing["t"]).all()


def test_rows_are_counted_without_a_copy() -> None:
    import tracemalloc

    log = sesc.Log({"hip": np.zeros(500_000), "cop_x": np.zeros(500_000)}, support="foot")
    tracemalloc.start()
    try:
        assert len(log) == 500_000 and "2 columns, 500000 rows" in repr(log)
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()


def test_settings_of_calls_are_checked(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    log = sesc.Log(columns, support="foot")
    with pytest.raises(sesc.FitError, match="noise"):
        sesc.fit(pole, log, noise=-1)
    with pytest.raises(sesc.FitError, match="robust"):
        sesc.fit(pole, log, robust="cauchy")  # type: ignore[arg-type]
    with pytest.raises(sesc.PriorError):
        sesc.fit(pole, log, prior="none.toml")  # type: ignore[arg-type]
    with pytest.raises(sesc.SescError, match="support"):
        sesc.fit(pole, columns)
    with pytest.raises(sesc.SupportError):
        sesc.fit(pole, log, support="fot")
    with pytest.raises(TypeError, match="robot"):
        sesc.fit(log)  # type: ignore[arg-type]
    with pytest.raises(sesc.PlanError):
        sesc.plan(pole, "foot", poses=0)
    with pytest.raises(sesc.SescError, match="known are"):
        sesc.simulate(pole.on("foot"), 3, hide={"joint_ofset:hip": 0.1})


def test_health_is_seen_with_and_without_a_robot(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    assert sesc.Log(columns, support="foot").health == []
    copied = {name: np.concatenate([column, column[:20]]) for name, column in columns.items()}
    copied["pose"] = np.arange(N + 20)
    kinds = [finding.kind for finding in sesc.Log(copied, support="foot").health]
    assert kinds == ["rows_copied"]
    dead = {**columns, "cop_x": np.full(N, 0.1), "cop_y": np.zeros(N)}
    found = sesc.Log(dead, support="foot", robot=pole).health
    assert any(finding.kind in ("cop_constant", "cop_axis_dead") for finding in found)
    with pytest.raises(sesc.LogError, match="cop_"):
        sesc.fit(pole, sesc.Log(dead, support="foot"))
    assert sesc.diagnose(pole, sesc.Log(dead, support="foot")).verdict == "unusable"


def test_logs_are_pickled(pole: sesc.Robot, columns: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(csv_of(columns))
    forms: list[Any] = [columns, tmp_path / "log.csv", csv_of(columns).encode()]
    for form in forms:
        log = sesc.Log(form, support="foot")
        again = pickle.loads(pickle.dumps(log))
        assert params(pole, again) == params(pole, log)
        assert "\n" not in repr(log) and log._repr_html_().startswith("<table>")


def test_a_table_is_copied(pole: sesc.Robot, columns: dict[str, Any]) -> None:
    mine = {name: column.copy() for name, column in columns.items()}
    log = sesc.Log(mine, support="foot")
    before = params(pole, log)
    mine["cop_x"][:] = 0.0
    assert params(pole, log) == before
