"""Results in the tables and figures that laboratories use."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sesc


@pytest.fixture(scope="module")
def log() -> sesc.Log:
    model = sesc.Robot(sesc.OP2_URDF).on("r_sole")
    return sesc.simulate(model, 200, range=0.5, noise=2e-4, hide={"joint_offset:r_knee": 0.026})


def test_a_log_goes_through_polars(log: sesc.Log) -> None:
    polars = pytest.importorskip("polars")
    robot = sesc.Robot(sesc.OP2_URDF)
    table = polars.DataFrame(log.columns())
    assert table.columns == ["pose", *robot.on("r_sole").joints, "cop_x", "cop_y", "cop_x_std", "cop_y_std"]
    again = sesc.Log(table.sort("pose", descending=True).sort("pose"), support="r_sole")
    np.testing.assert_array_equal(sesc.fit(robot, again).params, sesc.fit(robot, log).params)


def test_parameters_become_a_table(log: sesc.Log) -> None:
    polars = pytest.importorskip("polars")
    fit = sesc.fit(sesc.Robot(sesc.OP2_URDF), log, prior="cad")
    table = polars.DataFrame([row._asdict() for row in fit.parameters.values()])
    assert table.columns == ["name", "value", "std", "cad", "source"]
    np.testing.assert_array_equal(table["value"].to_numpy(), fit.params)
    named = table.filter(polars.col("name") == "r_knee_link.z")
    assert named["std"][0] == fit.parameters["r_knee_link.z"].std


def test_a_gap_is_drawn(log: sesc.Log, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib").use("Agg")
    pyplot = pytest.importorskip("matplotlib.pyplot")
    robot = sesc.Robot(sesc.OP2_URDF)
    columns = log.columns()
    measured = np.stack([columns["cop_x"], columns["cop_y"]], axis=-1)
    figure, axes = pyplot.subplots()
    gaps = {}
    for name, model in (("CAD", robot.on("r_sole")), ("found", sesc.diagnose(robot, log, prior="tight").model)):
        gaps[name] = 1e3 * (measured - sesc.predict(model, log)["cop"])
        axes.scatter(*gaps[name].T, label=name)
    figure.savefig(tmp_path / "gap.png")
    assert (tmp_path / "gap.png").stat().st_size > 5000
    # The offset is 0.026 rad; noise is 0.2 mm.
    assert np.sqrt(np.mean(gaps["CAD"] ** 2)) > 3 * np.sqrt(np.mean(gaps["found"] ** 2))
