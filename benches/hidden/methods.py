"""What the peers make of a log: each gets the log, CAD and the noise, and gives back predictions.

The correctors learn `reading − CAD's CoP` as a function of the joint positions and time; they know
nothing of a body, so the CoM stays CAD's.  Their place is the joint that their function depends on
most.  Least squares fits what a careful user would: offsets of all joints, masses and centres of all
links, offset, gain and rotation of the sensor, each with a prior.
"""

from __future__ import annotations

import json
import subprocess
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from robot import Robot

Array = NDArray[np.float64]


@dataclass
class Case:
    """A log, fresh postures without noise, and the truth."""

    folder: Path
    truth: dict[str, object]
    joints: list[str]
    robot: Robot
    t: Array
    q: Array
    cop: Array
    fresh_t: Array
    fresh_q: Array
    fresh_cop: Array
    fresh_com: Array

    @classmethod
    def read(cls, folder: Path, root: Path) -> Case:
        truth = json.loads((folder / "truth.json").read_text())
        header = (folder / "log.csv").open().readline().strip().split(",")
        joints = header[2:-2]
        log = np.loadtxt(folder / "log.csv", delimiter=",", skiprows=1)
        fresh = np.loadtxt(folder / "fresh.csv", delimiter=",", skiprows=1)
        n = len(joints)
        return cls(
            folder, truth, joints, Robot(root / str(truth["urdf"]), str(truth["support"]), joints),
            log[:, 0], log[:, 2 : 2 + n], log[:, 2 + n :],
            fresh[:, 0], fresh[:, 2 : 2 + n], fresh[:, 2 + n : 4 + n], fresh[:, 4 + n : 6 + n],
        )  # fmt: skip

    @property
    def noise(self) -> float:
        return float(str(self.truth["noise_m"]))

    def residual(self) -> Array:
        """Reading minus CAD's CoP, m."""
        return self.cop - self.robot.com(self.q)[:, :2]

    def inputs(self) -> tuple[Array, Array]:
        """Joint positions and time (0 to 1), of the log and of the fresh postures."""
        last = self.t[-1]
        return np.column_stack([self.q, self.t / last]), np.column_stack([self.fresh_q, self.fresh_t / last])


@dataclass
class Answer:
    """CoP and CoM of the fresh postures, m, and where the fault is said to be."""

    cop: Array
    com: Array
    places: list[str]


def corrected(case: Case, correction: Array, weights: Array) -> Answer:
    """The answer of a method that corrects the reading; `weights` of the joints and of time."""
    com = case.robot.com(case.fresh_q)[:, :2]
    names = [*case.joints, "time"]
    return Answer(com + correction, com, [names[int(np.argmax(weights))]] if weights.max() > 0 else [])


def pysindy(case: Case) -> Answer:
    """Thresholded regression on polynomials and sines; the threshold by cross-validation."""
    import pysindy as ps
    from sklearn.model_selection import KFold

    x, fresh = case.inputs()
    y = case.residual()
    library = ps.PolynomialLibrary(degree=2, include_interaction=False) + ps.FourierLibrary(n_frequencies=2)
    library.fit(x)
    columns, fresh_columns = np.asarray(library.transform(x)), np.asarray(library.transform(fresh))
    scale = np.maximum(columns.std(axis=0), 1e-9)
    scale[columns.std(axis=0) < 1e-9] = 1.0

    def fitted(rows: Array, threshold: float) -> Array:
        optimizer = ps.STLSQ(threshold=threshold, alpha=1e-2)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            optimizer.fit(columns[rows] / scale, y[rows])
        return np.asarray(optimizer.coef_)

    best = (np.inf, 0.0)
    for threshold in np.geomspace(1e-5, 1e-2, 10):
        error = 0.0
        for train, test in KFold(5, shuffle=True, random_state=0).split(x):
            coefficients = fitted(train, threshold)
            error += float(((y[test] - columns[test] / scale @ coefficients.T) ** 2).sum())
        best = min(best, (error, threshold))
    coefficients = fitted(np.arange(len(x)), best[1])
    names = library.get_feature_names([f"x{k}_" for k in range(x.shape[1])])
    weights = np.array([
        sum(float((coefficients[:, c] ** 2).sum()) for c, name in enumerate(names) if f"x{k}_" in name)
        for k in range(x.shape[1])
    ])  # fmt: skip
    return corrected(case, fresh_columns / scale @ coefficients.T, weights)


def gplearn(case: Case) -> Answer:
    """Symbolic regression of each axis."""
    from gplearn.genetic import SymbolicRegressor

    x, fresh = case.inputs()
    y = case.residual() / case.noise
    corrections, weights = [], np.zeros(x.shape[1])
    for axis in range(2):
        search = SymbolicRegressor(
            population_size=1000, generations=20, function_set=("add", "sub", "mul", "sin", "cos", "abs", "max"),
            const_range=(-20.0, 20.0), parsimony_coefficient=0.01, metric="mse", random_state=1, n_jobs=1,
        )  # fmt: skip
        search.fit(x, y[:, axis])
        corrections.append(search.predict(fresh) * case.noise)
        reading = search.predict(x)
        for k in range(x.shape[1]):
            other = x.copy()
            other[:, k] = x[:, k].mean()
            weights[k] += float(((search.predict(other) - reading) ** 2).mean())
    return corrected(case, np.stack(corrections, axis=1), weights)


def gaussian_process(case: Case) -> Answer:
    """A Gaussian process with a length scale for each joint and for time."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    x, fresh = case.inputs()
    y = case.residual() / case.noise
    mean, deviation = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-9)
    kernel = ConstantKernel(10.0, (1e-3, 1e5)) * RBF(np.full(x.shape[1], 3.0), (0.1, 1e3)) + WhiteKernel(1.0, "fixed")
    process = GaussianProcessRegressor(kernel, n_restarts_optimizer=1, random_state=1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        process.fit((x - mean) / deviation, y)
    lengths = process.kernel_.k1.k2.length_scale
    correction = np.asarray(process.predict((fresh - mean) / deviation)) * case.noise
    return corrected(case, correction, 1.0 / lengths)


def least_squares(case: Case) -> Answer:
    """All parameters of the URDF and of the sensor by scipy, each with a prior of its own."""
    from scipy.optimize import least_squares as solve

    robot, n = case.robot, len(case.joints)
    links = len(robot.links)
    # Offsets of 2°, masses of 10 %, centres of 5 mm; the sensor's zero 2 mm, gain 5 %, rotation 2°.
    widths = np.concatenate([
        np.full(n, np.radians(2.0)), 0.1 * np.maximum(robot.mass, 1e-6), np.full(3 * links, 0.005),
        [0.002, 0.002, 0.05, 0.05, np.radians(2.0)],
    ])  # fmt: skip

    def readings(z: Array, q: Array) -> tuple[Array, Array]:
        p = z * widths
        offsets, mass, centre, sensor = np.split(p, [n, n + links, n + 4 * links])
        com = robot.com(q + offsets, robot.mass + mass, robot.centre + centre.reshape(-1, 3))[:, :2]
        s, c = np.sin(sensor[4]), np.cos(sensor[4])
        return com @ np.array([[c, s], [-s, c]]) * (1 + sensor[2:4]) + sensor[:2], com

    def misfit(z: Array) -> Array:
        return np.concatenate([((readings(z, case.q)[0] - case.cop) / case.noise).ravel(), z])

    found = solve(misfit, np.zeros(len(widths)), method="trf", max_nfev=12)
    cop, com = readings(found.x, case.fresh_q)
    sizes = np.concatenate([np.abs(found.x[:n]), np.abs(found.x[n : n + links]), [np.abs(found.x[-5:]).max()]])
    names = [*case.joints, *robot.links, "sensor"]
    return Answer(cop, com, [names[int(np.argmax(sizes))]])


def sesc(case: Case, command: Path, root: Path) -> Answer:
    """`sesc diagnose` of the log, and `sesc predict` by the model file that it writes."""
    urdf, model = root / str(case.truth["urdf"]), case.folder / "model.toml"
    model.unlink(missing_ok=True)
    where = ["--support", str(case.truth["support"])]
    data, noise = str(case.folder / "log.csv"), str(case.noise)
    diagnose = [command, "diagnose", urdf, *where, "--data", data, "--noise", noise, "--out", model, "--json"]
    # 1: a discrepancy is named.
    done = subprocess.run(diagnose, capture_output=True, text=True)
    if done.returncode not in (0, 1, 3):
        raise RuntimeError(done.stderr)
    found = json.loads(done.stdout)
    fresh = np.column_stack([case.fresh_t, np.arange(len(case.fresh_t)), case.fresh_q])
    path = case.folder / "postures.csv"
    np.savetxt(path, fresh, delimiter=",", header=",".join(["t", "pose", *case.joints]), comments="", fmt="%.17g")
    by = ["--model", model] if model.exists() else []
    out = case.folder / "predicted.csv"
    predict = [command, "predict", urdf, *where, *by, "--data", path, "--out", out]
    subprocess.run(predict, capture_output=True, text=True, check=True)
    names = out.open().readline().strip().split(",")
    table = np.genfromtxt(out, delimiter=",", skip_header=1)
    of = [names.index(name) for name in ("cop_x", "cop_y", "com_x", "com_y")]
    steps = [step for step in found["steps"] if step["effect"] != "mass_distribution"]
    places = [
        "sensor" if step["effect"].startswith("sensor_") else part
        for step in steps
        for part in [step["target"].split(",")[0]]
    ]
    return Answer(table[:, of[:2]], table[:, of[2:]], places)
