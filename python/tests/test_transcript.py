"""The block that a roboticist types, as the documentation has it."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import repository


def test_the_block_runs(robots: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (repository() / "docs" / "python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", page, flags=re.S)
    assert blocks
    monkeypatch.chdir(tmp_path)
    shutil.copy(robots / "op2" / "op2.urdf", tmp_path / "op2.urdf")
    model = sesc.Robot("op2.urdf").on("r_sole")
    for name, seed in (("log.parquet", 1), ("monday.csv", 2), ("tuesday.csv", 3)):
        sesc.simulate(
            model, 100, range=0.5, noise=5e-4, seed=seed, hide={"joint_offset:r_knee": 0.026}
        ).save(name)
    space: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), space)
    assert np.shape(space["com"]) == (1000, 3)
    for file in ("model.toml", "found.html", "op2_corrected.urdf", "fw/op2_r_sole.h", "src/op2_r_sole.rs"):
        assert (tmp_path / file).stat().st_size > 100, file
