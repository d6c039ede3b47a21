"""Functions of arrays: against closed forms, derivatives and the command line."""

from __future__ import annotations

import html
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import sesc

from conftest import POLE, worded

RNG = np.random.default_rng(1)
FUNCTIONS = ["com", "com_jacobian", "gravity_moments", "cop", "cop_jacobian", "cop_rows", "com_rows", "full_rows"]


def test_a_pole_obeys_its_closed_form() -> None:
    """A mass at 1 m over a pitch axis at x = 0.1 m: (0.1 + sin q, 0, cos q)."""
    pole = sesc.Robot(POLE).on("foot")
    q = np.linspace(-1, 1, 7)[:, None]
    sin, cos, zero = np.sin(q[:, 0]), np.cos(q[:, 0]), np.zeros(7)
    np.testing.assert_allclose(pole.com(q), np.stack([0.1 + sin, zero, cos], 1), atol=1e-15)
    np.testing.assert_allclose(pole.com_jacobian(q)[:, :, 0], np.stack([cos, zero, -sin], 1), atol=1e-15)
    np.testing.assert_allclose(pole.gravity_moments(q)[:, 0], sin, atol=1e-15)
    np.testing.assert_allclose(pole.cop_jacobian(q)[:, :, 0], np.stack([cos, zero], 1), atol=1e-15)
    np.testing.assert_allclose(pole.cop(q), np.stack([0.1 + sin, zero], 1), atol=1e-15)
    assert pole.total_mass == 2.0
    np.testing.assert_array_equal(pole.limits, [[-1.0, 1.0]])


def test_zmp_of_a_point_mass_obeys_newton() -> None:
    pole = sesc.Robot(POLE).on("foot")
    q, qd, qdd = 0.3, 0.7, -1.1
    c = np.array([0.1 + math.sin(q), math.cos(q)])
    a = np.array(
        [math.cos(q) * qdd - math.sin(q) * qd**2, -math.sin(q) * qdd - math.cos(q) * qd**2]
    )
    want = c[0] - c[1] * a[0] / (9.80665 + a[1])
    assert pole.zmp([q], [qd], [qdd])[0] == pytest.approx(want, abs=1e-12)
    both = pole.zmp([[q], [0.0]], [[qd], [0.0]], [[qdd], [0.0]])
    np.testing.assert_allclose(both, [[want, 0.0], [0.1, 0.0]], atol=1e-12)


def test_op2_has_the_paper_s_numbers(model: sesc.Model, op2: sesc.Robot) -> None:
    assert model.dof == len(model.joints) == 20 and op2.joints == model.joints
    assert model.params.shape == (43,) and len(model.param_names) == 43
    assert model.limits.shape == (20, 2) and (model.limits[:, 0] < model.limits[:, 1]).all()
    # An axis of each joint, and the height.
    assert len(model.unobservable) == 21
    assert any("height" in sentence for sentence in model.unobservable)
    assert model.total_mass == pytest.approx(2.8, abs=0.3)


def test_rows_times_parameters_are_the_functions(model: sesc.Model) -> None:
    q = RNG.uniform(-1, 1, (100, 20))
    np.testing.assert_allclose(model.com_rows(q) @ model.params, model.com(q), atol=1e-14)
    np.testing.assert_allclose(model.cop_rows(q) @ model.params, model.cop(q), atol=1e-14)
    np.testing.assert_array_equal(model.cop_rows(q), model.com_rows(q)[:, :2])
    assert model.cop_rows(q).shape == (100, 2, 43) and model.cop_rows(q[0]).shape == (2, 43)


def test_the_velocity_is_the_jacobian_times_rates(model: sesc.Model) -> None:
    q, qd = RNG.uniform(-1, 1, (2, 70, 20))
    want = np.einsum("nij,nj->ni", model.com_jacobian(q), qd)
    np.testing.assert_allclose(model.com_velocity(q, qd), want, atol=1e-14)
    np.testing.assert_allclose(model.com_velocity(q[0], qd[0]), want[0], atol=1e-14)
    with pytest.raises(TypeError, match="shapes"):
        model.com_velocity(q, qd[0])


def test_full_rows_of_a_pole_are_its_rotations() -> None:
    """[1, R_y(q)]: the foot's own frame, and that of the top."""
    pole = sesc.Robot(POLE).on("foot")
    q = 0.3
    top = np.array([[math.cos(q), 0, math.sin(q)], [0, 1, 0], [-math.sin(q), 0, math.cos(q)]])
    want: np.ndarray[Any, Any] = np.hstack([np.eye(3), top])
    np.testing.assert_allclose(pole.full_rows([q]), want, atol=1e-15)
    # The hip is 0.1 m in front of the sole's origin, the mass 1 m along the top.
    np.testing.assert_allclose(want @ [0.1, 0, 0, 0, 0, 1.0], pole.com([q]), atol=1e-15)


SENSOR = """robot = "pole"
hash = "{hash}"
support = "foot"
{parameters}[[effects]]
effect = "sensor_offset"
parameters.offset_x_m = {{ value = 0.003 }}
parameters.offset_y_m = {{ value = -0.002 }}
"""


def test_the_cop_is_corrected_where_the_model_has_effects_of_the_sensor(tmp_path: Path) -> None:
    robot = sesc.Robot(POLE)
    plain = robot.on("foot")
    cop = RNG.uniform(-0.05, 0.05, (100, 2))
    np.testing.assert_array_equal(plain.correct_cop(cop), cop)
    named = zip(plain.param_names, plain.params.tolist(), strict=True)
    cad = [f'[[parameters]]\nname = "{name}"\nvalue = {value!r}\nsource = "cad"\n' for name, value in named]
    (tmp_path / "model.toml").write_text(SENSOR.format(hash=robot.hash, parameters="".join(cad)))
    model = robot.on("foot", model=tmp_path / "model.toml")
    read = cop + [0.003, -0.002]
    np.testing.assert_allclose(model.correct_cop(read), cop, atol=1e-15)
    np.testing.assert_allclose(model.correct_cop(read[0]), cop[0], atol=1e-15)
    np.testing.assert_array_equal(model.correct_cop({"cop_x": read[:, 0], "cop_y": read[:, 1]}), model.correct_cop(read))
    q = RNG.uniform(-1, 1, (50, 1))
    np.testing.assert_allclose(model.correct_cop(model.cop(q)), plain.cop(q), atol=1e-15)
    with pytest.raises(ValueError, match="must hold x and y of a reading"):
        model.correct_cop([[0.1, 0.2, 0.3]])


def test_threads_may_call_one_model_at_once(robots: Path) -> None:
    from concurrent.futures import ThreadPoolExecutor

    model = sesc.Robot(robots / "op2" / "op2.urdf").on("r_sole")
    q = RNG.uniform(-1, 1, (3000, 20))
    calls = [(name, part) for name in FUNCTIONS for part in np.array_split(q, 8)]
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda call: getattr(model, call[0])(call[1], threads=2), calls))
    fresh = sesc.Robot(robots / "op2" / "op2.urdf").on("r_sole")
    for (name, part), result in zip(calls, found):
        np.testing.assert_array_equal(result, getattr(fresh, name)(part))


PEAK = """
import resource, sys, numpy as np, sesc
model = sesc.Robot(sesc.OP2_URDF).on("r_sole")
q = np.random.default_rng(1).uniform(-0.5, 0.5, (100_000, 20))
call = getattr(model, sys.argv[1])
call(q[:1000], threads=2)
peak = lambda: 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
before = peak()
result = call(q, threads=2)
print(peak() - before - result.nbytes)
"""


@pytest.mark.parametrize("name", ["com", "com_jacobian", "cop_rows"])
def test_a_batch_takes_the_memory_of_its_result(name: str) -> None:
    pytest.importorskip("resource")
    done = subprocess.run([sys.executable, "-c", PEAK, name], capture_output=True, text=True, check=True)
    assert int(done.stdout) < 1_000_000


def test_jacobian_and_moments_are_derivatives(model: sesc.Model) -> None:
    q, h = RNG.uniform(-1, 1, 20), 1e-6
    steps = h * np.eye(20)
    slopes = (model.com(q + steps) - model.com(q - steps)) / (2 * h)
    np.testing.assert_allclose(model.com_jacobian(q), slopes.T, atol=1e-9)
    np.testing.assert_allclose(model.gravity_moments(q), -slopes[:, 2], atol=1e-9)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("n", [0, 1, 7, 63, 64, 65, 1000, 100_000])
def test_a_batch_is_its_postures(model: sesc.Model, name: str, n: int) -> None:
    function = getattr(model, name)
    q = RNG.uniform(-1, 1, (n, 20))
    batch = function(q)
    some = RNG.integers(0, n, 1000) if n > 1000 else np.arange(n)
    single = np.array([function(row) for row in q[some]]).reshape(batch[some].shape)
    np.testing.assert_array_equal(batch[some], single)
    np.testing.assert_array_equal(function(q, threads=3), batch)
    out = np.full_like(batch, np.nan)
    assert function(q, out=out) is out
    np.testing.assert_array_equal(out, batch)


@given(
    n=st.sampled_from([0, 1, 7, 63, 64, 65]),
    kind=st.sampled_from(["<f8", ">f8", "<f4", "<f2", "<i4", "<i8", "<u2"]),
    order=st.sampled_from("CF"),
    step=st.sampled_from([1, 2, -1]),
    frozen=st.booleans(),
)
@settings(deadline=None, max_examples=60)
def test_any_array_of_numbers_is_taken(n: int, kind: str, order: Any, step: int, frozen: bool) -> None:
    pole = sesc.Robot(POLE).on("foot")
    q = np.zeros((n, 1), dtype=kind, order=order)
    q[:, 0] = np.arange(n) % 2
    q = q[::step]
    q.flags.writeable = not frozen
    want = pole.com([[float(x)] for x in q[:, 0]] if n else np.zeros((0, 1)))
    np.testing.assert_array_equal(pole.com(q), want)


@given(hnp.arrays(np.float64, (5, 3), elements=st.floats(-3, 3)))
@settings(deadline=None, max_examples=30)
def test_outer_axes_are_kept(q: np.ndarray) -> None:
    pole = sesc.Robot(POLE).on("foot")
    assert pole.com(q[:, :, None]).shape == (5, 3, 3)
    np.testing.assert_array_equal(pole.com(q[:, :, None])[2, 1], pole.com([q[2, 1]]))


def test_nan_stays_in_its_posture(model: sesc.Model) -> None:
    q = RNG.uniform(-1, 1, (70, 20))
    want = model.com(q)
    q[3, 5] = np.nan
    got = model.com(q)
    assert np.isnan(got[3]).any()
    np.testing.assert_array_equal(np.delete(got, 3, 0), np.delete(want, 3, 0))


def test_a_masked_value_is_nan_in_its_posture(model: sesc.Model, tmp_path: Path) -> None:
    q = RNG.uniform(-1, 1, (5, 20))
    masked = np.ma.masked_array(q, mask=np.zeros((5, 20), bool))
    np.testing.assert_array_equal(model.com(masked), model.com(q))
    masked[2, 7] = np.ma.masked
    got = model.com(masked)
    assert type(got) is np.ndarray and np.isnan(got[2]).any()
    np.testing.assert_array_equal(np.delete(got, 2, 0), np.delete(model.com(q), 2, 0))
    named = {name: masked[:, k] for k, name in enumerate(model.joints)}
    np.testing.assert_array_equal(model.com(named), got)
    np.testing.assert_array_equal(model.com(model.reordered(masked)), got)
    with pytest.raises(TypeError, match="out has a mask"):
        model.com(q, out=np.ma.zeros((5, 3)))
    place = np.memmap(tmp_path / "out", dtype=np.float64, shape=(5, 3), mode="w+")
    np.testing.assert_array_equal(model.com(q, out=place), model.com(q))


def test_joints_are_found_by_name(model: sesc.Model) -> None:
    q = RNG.uniform(-1, 1, (9, 20))
    columns = {name: q[:, k] for k, name in reversed(list(enumerate(model.joints)))}
    np.testing.assert_array_equal(model.com({"t": np.zeros(9), **columns}), model.com(q))
    del columns["r_knee"]
    with pytest.raises(ValueError, match="r_knee"):
        model.com(columns)


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda m: m.com(np.zeros(19)), ValueError, "20 joints"),
        (lambda m: m.com(np.zeros((20, 3))), ValueError, "20 joints"),
        (lambda m: m.com(0.0), ValueError, "20 joints"),
        (lambda m: m.com(["a"] * 20), TypeError, "numbers"),
        (lambda m: m.com(np.zeros(20, complex)), TypeError, "complex"),
        (lambda m: m.com(np.zeros(20), out=np.zeros(2)), ValueError, "shape"),
        (lambda m: m.com(np.zeros(20), out=np.zeros(3, np.float32)), TypeError, "64-bit"),
        (lambda m: m.com(np.zeros((4, 20)), out=np.zeros((4, 6))[:, ::2]), ValueError, "gaps"),
        (lambda m: m.com(np.zeros((64, 20)), threads=0), ValueError, "threads"),
        (lambda m: m.com(np.zeros(20), threads=2.0), TypeError, "threads is 2.0; give a whole number, 1 or more"),
        (lambda m: m.com([[0.1] * 20, [0.2] * 19]), ValueError, "q has rows of different lengths; give every posture"),
        (lambda m: m.reordered([[0.1, 0.2], [0.3]]), ValueError, "q has rows of different lengths"),
        (lambda m: m.zmp(np.zeros(20), np.zeros(20), np.zeros((1, 20))), TypeError, "one shape"),
    ],
)
def test_what_cannot_be_taken_is_said(model: sesc.Model, call: Any, error: Any, words: str) -> None:
    with pytest.raises(error, match=words) as caught:
        call(model)
    kind = sesc.ArgumentTypeError if error is TypeError else sesc.ArgumentError
    assert type(caught.value) is kind and isinstance(caught.value, (sesc.SescError, ValueError))


def test_out_is_not_written_over_q() -> None:
    pole = sesc.Robot(POLE).on("foot")
    memory = np.zeros(3)
    with pytest.raises(ValueError, match="shares memory"):
        pole.com(memory[:1], out=memory)
    frozen = np.zeros(3)
    frozen.flags.writeable = False
    with pytest.raises(ValueError, match="out is read-only; give an array that is writeable"):
        pole.com([0.0], out=frozen)


def test_functions_equal_those_of_the_command(model: sesc.Model, robots: Path, command: Any, tmp_path: Path) -> None:
    q = RNG.uniform(-0.5, 0.5, (100, 20))
    rows = [",".join([str(k), *map(repr, map(float, row))]) for k, row in enumerate(q)]
    (tmp_path / "q.csv").write_text("\n".join([",".join(["pose", *model.joints]), *rows]) + "\n")
    printed = command("predict", robots / "op2/op2.urdf", "--support", "r_sole", "--data", tmp_path / "q.csv")
    table = np.array([line.split(",") for line in printed.splitlines()[1:]], dtype=float)
    np.testing.assert_array_equal(table[:, 1:4], model.com(q))
    np.testing.assert_array_equal(table[:, 4:6], model.cop(q))


def test_inspection_equals_the_command(model: sesc.Model, robots: Path, command_json: Any) -> None:
    inspected = command_json("inspect", robots / "op2/op2.urdf", "--support", "r_sole")
    assert worded(model.to_dict()) == worded(inspected)
    call = 'sesc.plan(robot, support="r_sole", poses=40).save("poses.csv")'
    assert model.to_dict()["next_steps"][0]["command"] == call
    assert f"<code>{html.escape(call)}</code>" in model._repr_html_()
