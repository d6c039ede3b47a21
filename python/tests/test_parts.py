"""Parts as bytes: small, the same after they are saved and loaded."""

from __future__ import annotations

import json
import os
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc


def test_a_part_of_the_op2_is_100_kb_and_its_urdf(op2: sesc.Robot, model: sesc.Model) -> None:
    for postures in (100, 5000):
        part = sesc.gather(op2, sesc.simulate(model, postures, range=0.5, noise=1e-4))
        assert len(bytes(part)) <= 100_000 + len(op2.urdf)
        assert sesc.Part.from_bytes(bytes(part)) == part


def test_parts_of_deviations_of_their_own_keep_both_sums(op2: sesc.Robot, model: sesc.Model) -> None:
    log = sesc.simulate(model, 100, range=0.5, noise=1e-4)
    columns = dict(log.columns() or {})
    columns["cop_x_std"] = columns["cop_x_std"] * np.linspace(0.5, 2.0, 100)
    part = sesc.gather(op2, sesc.Log(columns, support="r_sole"))
    assert 160_000 < len(bytes(part)) <= 200_000 + len(op2.urdf)
    # One deviation first, then many: the same rows as all at once.
    more = sesc.gather(op2, sesc.simulate(model, 100, range=0.5, noise=1e-4, seed=2))
    np.testing.assert_allclose(sesc.fit(more | part).params, sesc.fit(part | more).params, atol=1e-12)


def half(model: sesc.Model, seed: int) -> sesc.Log:
    return sesc.simulate(model, 40, noise=1e-4, seed=seed)


def test_a_part_is_saved_and_loaded(pole: sesc.Robot, tmp_path: Path) -> None:
    part = sesc.gather(pole, half(pole.on("foot"), 1))
    part.save(tmp_path / "a.part")
    assert os.listdir(tmp_path) == ["a.part"]
    assert (tmp_path / "a.part").read_bytes() == bytes(part)
    assert sesc.Part.load(tmp_path / "a.part") == part
    with pytest.raises(OSError):
        part.save(tmp_path / "nowhere" / "a.part")


def test_parts_of_two_units_are_refused(pole: sesc.Robot) -> None:
    model = pole.on("foot")
    a = sesc.gather(pole, half(model, 1), unit="r07")
    b = sesc.gather(pole, half(model, 2), unit="r12")
    c = sesc.gather(pole, half(model, 3))
    assert (a.unit, c.unit) == ("r07", None) and "r07" in repr(a)
    assert sesc.Part.from_bytes(bytes(a)).unit == a.to_dict()["unit"] == "r07"
    words = "of unit `r12`, and the first part is of unit `r07`"
    with pytest.raises(sesc.PartError, match=words):
        a | b
    with pytest.raises(ValueError, match=words):
        sesc.fit([a, b])
    with pytest.raises(ValueError, match="not of `unit` `r12`"):
        sesc.fit(a, unit="r12")
    with pytest.raises(ValueError, match="`unit` is empty"):
        sesc.gather(pole, half(model, 1), unit=" ")
    # Of a part that does not say it, nobody knows better.
    assert (a | c).unit == (c | a).unit == "r07"
    assert sesc.fit([a, c], unit="r07").postures == 80


def test_parts_of_other_options_are_refused(pole: sesc.Robot) -> None:
    model = pole.on("foot")
    logs = [sesc.simulate(model, 200, rate=50.0, noise=1e-4, seed=seed) for seed in (1, 2)]
    usual = sesc.gather(pole, logs[0])
    assert usual.options == {"motion": "auto", "stays": "pooled", "robust": None}
    still = sesc.gather(pole, logs[1], motion="off")
    with pytest.raises(sesc.PartError, match="`motion` off, the first part with auto; gather both alike"):
        usual | still
    with pytest.raises(ValueError, match="`motion` auto, the first part with off"):
        sesc.fit(pole, [still, logs[0]])
    assert sesc.fit(pole, [still, logs[0]], motion="off").postures == 400
    with pytest.raises(ValueError, match="`motion`, but the parts were gathered otherwise"):
        sesc.fit(usual, motion="off")
    robust = sesc.gather(pole, half(model, 1), robust="huber")
    assert robust.options is not None and robust.options["robust"] == "huber"
    with pytest.raises(sesc.PartError, match="`robust` huber, the first part with none"):
        usual | robust


def test_logs_that_are_there_already_are_refused_or_left_out(pole: sesc.Robot) -> None:
    model = pole.on("foot")
    a, b, c = (sesc.gather(pole, half(model, seed)) for seed in (1, 2, 3))
    with pytest.raises(ValueError, match="is in both: its postures would count twice"):
        sesc.fit([a, b, a])
    once = sesc.fit([a, b])
    for parts in ([a, b, a], [a, a | b], [a | b, b], [a | b, a | b]):
        again = sesc.fit(parts, duplicates="skip")
        assert again.postures == 80
        np.testing.assert_allclose(again.params, once.params, atol=1e-12)
    # Sums of one log cannot be taken out of a part of several.
    with pytest.raises(ValueError, match="is in both"):
        sesc.fit([a | b, b | c], duplicates="skip")
    with pytest.raises(sesc.FitError, match="`duplicates` drop: known are refuse, skip"):
        sesc.fit([a, b], duplicates="drop")  # type: ignore[arg-type]


def halves(part: sesc.Part) -> tuple[dict[str, Any], bytes]:
    """The header of a part, and the sums behind it."""
    data = bytes(part)
    header = zlib.decompressobj(31)
    text = header.decompress(data)
    return json.loads(text), header.unused_data


def test_a_part_depends_on_what_a_log_holds_alone(pole: sesc.Robot, tmp_path: Path) -> None:
    """Of one table the bytes are the same; files of other formats have hashes of their own, and
    the same sums to the bit."""
    pa: Any = pytest.importorskip("pyarrow")
    parquet: Any = pytest.importorskip("pyarrow.parquet")
    simulated = half(pole.on("foot"), 1)
    columns = dict(simulated.columns() or {})
    rows = zip(*(map(repr, column.tolist()) for column in columns.values()))
    lines = [",".join(columns), *(",".join(row) for row in rows)]
    (tmp_path / "log.csv").write_text("\n".join(lines) + "\n")
    parquet.write_table(pa.table(columns), tmp_path / "log.parquet")
    forms = [columns, pa.table(columns), tmp_path / "log.csv", tmp_path / "log.parquet"]
    parts = [sesc.gather(pole, sesc.Log(form, support="foot")) for form in forms]
    assert bytes(parts[0]) == bytes(parts[1])
    header, sums = halves(parts[0])
    for part in parts[1:]:
        own, numbers = halves(part)
        assert numbers == sums
        assert own["gathered"].pop("logs")[0]["rows"] == 40
        assert own == {**header, "gathered": {k: v for k, v in header["gathered"].items() if k != "logs"}}
