"""What cannot be used is said by its name, whatever a caller gives: never a panic, no word of what
is inside."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import POLE

ROBOT = sesc.Robot(POLE)
MODEL = ROBOT.on("foot")
HIP = 0.6 * np.sin(0.7 * np.arange(40))
COLUMNS = {
    "hip": HIP,
    "cop_x": 0.1 + np.sin(HIP) + 1e-4 * np.sin(7.1 * np.arange(40)),
    "cop_y": 1e-4 * np.sin(3.3 * np.arange(40)),
}


@pytest.fixture(scope="module")
def log() -> sesc.Log:
    return sesc.Log(COLUMNS, support="foot")


def plan(**options: Any) -> sesc.Plan:
    usual: dict[str, Any] = {"poses": 3, "candidates": 50, "cop_box": 0.3, "sigmas": 0.0}
    return sesc.plan(ROBOT, "foot", **{**usual, **options})


#: Calls of one option, by what the option takes.
WHOLE: dict[str, Callable[[Any, sesc.Log], Any]] = {
    "folds": lambda given, log: sesc.fit(ROBOT, log, folds=given),
    "poses": lambda given, log: plan(poses=given),
    "candidates": lambda given, log: plan(candidates=given),
    "revisits": lambda given, log: plan(revisits=given),
    "seed": lambda given, log: plan(seed=given),
    "samples": lambda given, log: sesc.verify(MODEL, samples=given),
    "lanes": lambda given, log: MODEL.c99("nowhere", lanes=given),
    "readings_per_pose": lambda given, log: sesc.Log(COLUMNS, readings_per_pose=given),
}
NUMBERS: dict[str, Callable[[Any, sesc.Log], Any]] = {
    "noise": lambda given, log: sesc.fit(ROBOT, log, noise=given),
    "range": lambda given, log: sesc.fit(ROBOT, log, range=given),
    "settle": lambda given, log: sesc.gather(ROBOT, log, settle=given),
    "floor": lambda given, log: sesc.diagnose(ROBOT, log, floor=given),
    "rate": lambda given, log: sesc.simulate(MODEL, 9, rate=given),
    "cop_box": lambda given, log: plan(cop_box=given),
    "margin": lambda given, log: plan(margin=given),
    "sigmas": lambda given, log: plan(sigmas=given),
    "clearance": lambda given, log: plan(clearance=given),
    "total_mass": lambda given, log: sesc.fit(ROBOT, log, noise=1e-4).correct_urdf(total_mass=given),
}


@pytest.mark.parametrize("name", [*WHOLE, *NUMBERS])
def test_a_number_that_cannot_be_is_an_error_that_names_its_option(name: str, log: sesc.Log, capfd: Any) -> None:
    call = (WHOLE | NUMBERS)[name]
    for given in (-1, 10**30) if name in WHOLE else (-1.0, float("nan"), float("inf")):
        with pytest.raises((sesc.SescError, OverflowError)) as caught:
            call(given, log)
        assert name in str(caught.value) or isinstance(caught.value, OverflowError), caught.value
        assert isinstance(caught.value, sesc.SescError) or given == 10**30
    for other in ("many", [1]):
        with pytest.raises((TypeError, sesc.LogError)) as wrong:
            call(other, log)
        assert "Options" not in str(wrong.value) and "extract" not in str(wrong.value)
        assert name in str(wrong.value) or name == "window", wrong.value
    assert capfd.readouterr() == ("", "")


#: Millimetres, degrees, grams and nanoseconds in place of SI units.
OTHER_UNITS: list[tuple[Callable[[sesc.Log], Any], str]] = [
    *[
        (call, "`noise` 5.0: that is 5 m; give metres: 0.005 for 5 mm")
        for call in (
            lambda log: sesc.fit(ROBOT, log, noise=5),
            lambda log: sesc.gather(ROBOT, log, noise=5),
            lambda log: sesc.diagnose(ROBOT, log, noise=5),
            lambda log: plan(noise=5),
            lambda log: sesc.simulate(MODEL, 9, noise=5),
            lambda log: sesc.fleet.run(ROBOT, [], noise=5),
        )
    ],
    (lambda log: sesc.diagnose(ROBOT, log, floor=0.2), "`floor` 0.2: that is 0.2 m"),
    (lambda log: plan(cop_box=30), "`cop_box` 30.0: that is 30 m"),
    (lambda log: plan(margin=10), "`margin` 10.0: that is 10 m"),
    (lambda log: plan(clearance=5), "`clearance` 5.0: that is 5 m"),
    (lambda log: sesc.simulate(MODEL, 9, range=30), "`range` 30.0: that is 30 rad, more than a turn; give radians: 0.5236 for 30°"),
    (lambda log: sesc.fit(ROBOT, log, range=1e9), "`range` 1000000000.0: give radians, 6.2832 at most"),
    (lambda log: sesc.simulate(MODEL, 9, rate=1e7), "`rate` 10000000.0: that is 10000000 rows a second"),
    (lambda log: sesc.fit(ROBOT, log, noise=1e-4).correct_urdf(total_mass=2000), "`total_mass` 2000.0: that is 2000 kg"),
    (lambda log: sesc.diagnose(ROBOT, log).correct_urdf(total_mass=2000), "`total_mass` 2000.0: that is 2000 kg"),
    (
        lambda log: sesc.simulate(MODEL, 9, hide={"joint_offset:hip": 1.2}),
        "`joint_offset:hip=1.2`: 1.2 of offset_rad is 1.2 rad (69°); give its unit: 1.2deg, or 1.2rad if that is meant",
    ),
    (lambda log: sesc.simulate(MODEL, 9, hide={"sensor_offset": (5, 0)}), "5.0 m (5000 mm)"),
    (lambda log: sesc.simulate(MODEL, 9, hide={"payload:top": (200, 0, 0, 0)}), "200.0 kg (the robot weighs 2.000 kg)"),
]


@pytest.mark.parametrize(("call", "words"), OTHER_UNITS)
def test_what_the_command_refuses_by_its_size_is_refused(call: Callable[[sesc.Log], Any], words: str, log: sesc.Log) -> None:
    with pytest.raises(sesc.SescError, match=re.escape(words)):
        call(log)


def test_a_size_with_its_unit_is_taken() -> None:
    meant = sesc.simulate(MODEL, 9, hide={"joint_offset:hip": "1.2rad"}).columns()
    assert np.abs(meant["cop_x"] - sesc.simulate(MODEL, 9).columns()["cop_x"]).max() > 0.1


def test_words_are_known_to_checkers_of_types(log: sesc.Log) -> None:
    """An ignored error that there is not would be one of mypy."""
    with pytest.raises(sesc.PriorError):
        sesc.fit(ROBOT, log, prior="loose")  # type: ignore[arg-type]
    with pytest.raises(sesc.FitError):
        sesc.fit(ROBOT, log, robust="hubert")  # type: ignore[arg-type]
    with pytest.raises(sesc.ArgumentError):
        sesc.diagnose(ROBOT, log, motion="on")  # type: ignore[arg-type]
    with pytest.raises(sesc.SescError):
        MODEL.c99("nowhere", scalar="f16")  # type: ignore[arg-type]
    with pytest.raises(sesc.SescError):
        sesc.fleet.run(ROBOT, [], only="fits")  # type: ignore[arg-type]


def test_a_package_shows_what_is_meant() -> None:
    assert dir(sesc) == sorted(sesc.__all__) and not {"Any", "TYPE_CHECKING"} & set(dir(sesc))


def test_limits_of_no_range_are_an_error_of_the_joint() -> None:
    for limits, words in (
        ({"hip": (1, -1)}, "joint `hip`: lower 1 is above upper -1; swap them"),
        ({"hip": (float("nan"), 1)}, "joint `hip`: NaN to 1 is no range"),
        ({"hip": (2.0, 3.0)}, "outside the URDF's"),
        ({"hips": (0.0, 1.0)}, "did you mean `hip`"),
    ):
        with pytest.raises(sesc.PlanError, match=re.escape(words)):
            plan(limits=limits)
    assert np.abs(plan(limits={"hip": (-0.2, 9.0)}).q).max() <= 1.0
    for sole in ([[0, 0]], [0, 0, 1], [[0, 0, 0]] * 3):
        with pytest.raises(sesc.PlanError, match="`sole` has the shape"):
            plan(sole=sole, cop_box=None)


def test_calls_of_one_log_take_one(log: sesc.Log) -> None:
    calls: list[Callable[[Any], Any]] = [
        lambda given: sesc.diagnose(ROBOT, given),
        lambda given: sesc.predict(MODEL, given),
        lambda given: plan(data=given),
    ]
    for call in calls:
        for given in ([], [log, log]):
            with pytest.raises(sesc.SescError, match=f"one log is asked for, not {len(given)}"):
                call(given)


def test_arguments_of_other_types_are_errors_of_the_package_and_of_python(log: sesc.Log, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("hip,cop_x,cop_y\n0,0,0\n")
    calls: list[tuple[Callable[[], Any], str]] = [
        (lambda: ROBOT.on(None), "`support` None: give the name of a link; the robot has foot, top"),  # type: ignore[arg-type]
        (lambda: sesc.Robot(3), "a URDF is given by its path"),
        (lambda: sesc.fit(3, log), "a robot or a part comes first, not int"),  # type: ignore[arg-type]
        (lambda: sesc.gather(MODEL, log), "a robot comes first, not Model"),  # type: ignore[arg-type]
        (lambda: sesc.diagnose(MODEL, log), "a robot comes first, not Model"),  # type: ignore[arg-type]
        (lambda: sesc.plan(MODEL, "foot", poses=3), "a robot comes first, not Model"),  # type: ignore[arg-type]
        (lambda: sesc.verify(ROBOT), "a model comes first, not Robot"),  # type: ignore[arg-type]
        (lambda: sesc.simulate(ROBOT, 3), "a model comes first, not Robot"),  # type: ignore[arg-type]
        (lambda: sesc.predict(ROBOT, log), "a model comes first, not Robot"),  # type: ignore[arg-type]
        (lambda: sesc.Log(3), "a log is a path"),
        (lambda: sesc.Log(tmp_path / "log.csv").columns(), "is a file"),
        (lambda: sesc.fit(ROBOT, log, noise="many"), "`noise` 'many'"),  # type: ignore[arg-type]
    ]
    for call, words in calls:
        with pytest.raises(TypeError, match=re.escape(words)) as caught:
            call()
        assert type(caught.value) is sesc.ArgumentTypeError and isinstance(caught.value, sesc.ArgumentError)
        again = pickle.loads(pickle.dumps(caught.value))
        assert type(again) is sesc.ArgumentTypeError and str(again) == str(caught.value)
    for option in ("angles", "motion"):
        with pytest.raises(sesc.ArgumentError, match=f"`{option}` 'much': give"):
            sesc.fit(ROBOT, log, **{option: "much"})  # type: ignore[arg-type]


def test_postures_are_counted_in_whole_numbers(log: sesc.Log) -> None:
    with pytest.raises(TypeError, match="`poses` 1.5: give a whole number"):
        sesc.simulate(MODEL, 1.5)
    with pytest.raises(sesc.LogError, match="`poses` -3: give a whole number, zero or more"):
        sesc.simulate(MODEL, -3)
    assert len(sesc.simulate(MODEL, np.int64(3))) == len(sesc.simulate(MODEL, [0.1])) + 2 == 3
    found = sesc.diagnose(ROBOT, log, noise=1e-4)
    with pytest.raises(sesc.FitError, match="`n` -1: give a whole number, zero or more"):
        found.next_postures(-1)
    with pytest.raises(ValueError, match="threads is -1; give 1 or more"):
        MODEL.com(np.zeros((1000, 1)), threads=-1)


def test_columns_and_settings_of_a_log_are_said_by_name() -> None:
    bad: list[tuple[Callable[[], Any], str]] = [
        (lambda: sesc.Log({"hip": np.zeros((3, 3))}), "column `hip`: its shape is (3, 3)"),
        (lambda: sesc.Log({"hip": [[1], [2, 3]]}), "column `hip`"),
        (lambda: sesc.Log(COLUMNS, support=3), "`support` 3"),  # type: ignore[arg-type]
        (lambda: sesc.Log(COLUMNS, gravity=[1, 2]), "`gravity` [1.0,2.0]"),
        (lambda: sesc.Log(COLUMNS, cells=[[1, 2], [3]]), "`cells`"),
        (lambda: sesc.Log(COLUMNS, columns={"a": 3}), "`columns`"),  # type: ignore[dict-item]
    ]
    for call, words in bad:
        with pytest.raises(sesc.LogError) as caught:
            call()
        assert words in str(caught.value)


def test_files_that_cannot_be_read_are_errors_of_python_too(tmp_path: Path) -> None:
    calls: list[tuple[Callable[[Path], Any], type[sesc.SescError]]] = [
        (sesc.Robot, sesc.UrdfError),
        (lambda path: ROBOT.on("foot", path), sesc.ModelFileError),
        (sesc.Log, sesc.LogError),
        (sesc.Part.load, sesc.PartError),
        (lambda path: plan(limits=path), sesc.PlanError),
    ]
    for call, kind in calls:
        with pytest.raises(FileNotFoundError) as caught:
            call(tmp_path / "none")
        assert isinstance(caught.value, kind), kind
        assert isinstance(caught.value, sesc.SescError) and caught.value.file == str(tmp_path / "none")
    with pytest.raises(sesc.UrdfError, match="robot.urdf:2: byte 0xff is not UTF-8") as coded:
        sesc.Robot(b"<robot>\n\xff</robot>")
    assert coded.value.line == 2


def test_arrays_at_any_address_are_taken() -> None:
    """Numbers may begin at any byte of a buffer, as fields of records and of files do."""
    q = np.linspace(-1, 1, 5)[:, None]
    shifted = np.frombuffer(b"x" + q.tobytes(), dtype=np.float64, offset=1).reshape(5, 1)
    assert not shifted.flags.aligned
    np.testing.assert_array_equal(MODEL.com(shifted), MODEL.com(q))
    out = np.frombuffer(bytearray(b"x" + bytes(5 * 24)), dtype=np.float64, offset=1).reshape(5, 3)
    with pytest.raises(sesc.ArgumentTypeError, match="out is not aligned in memory"):
        MODEL.com(q, out=out)
    records = np.zeros(5, dtype=[("flag", "u1"), ("q", "<f8", (1,))])
    records["q"] = q
    np.testing.assert_array_equal(MODEL.com(records["q"]), MODEL.com(q))
