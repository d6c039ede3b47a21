"""Functions from Python beside the same calls from Rust and in other packages, in one run:
nanoseconds a posture.

    pip install ./python pin mujoco "adam-robotics[casadi]"
    python benches/python.py [URDF SUPPORT]      # the OP2 on its right sole unless given

Each number is the least of many short repeats, which other programs leave alone. Rust's are those of `cargo bench --bench tape`.
Pinocchio and MuJoCo have no batches in Python, so that a loop is what their users write; adam
writes functions for CasADi, whose `map` evaluates batches. Packages that are not installed are
left out. `--fit` times `sesc.fit` of a million rows of a data frame beside the command on the
same rows in Parquet.
"""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
import tempfile
import time
import timeit
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import sesc

ROOT = Path(__file__).resolve().parents[1]
POSTURES = 10_000
#: Functions, and how many arrays each takes: positions, velocities, accelerations.
FUNCTIONS = {
    "com": 1,
    "com_jacobian": 1,
    "com_velocity": 2,
    "gravity_moments": 1,
    "cop": 1,
    "cop_rows": 1,
    "com_rows": 1,
    "full_rows": 1,
    "zmp": 3,
}
#: For packages that take microseconds a posture.
FEW = 500


def least(call: Callable[[], object], number: int, per: int = 1, repeat: int = 300) -> float:
    """Nanoseconds of one of `per` postures in one call."""
    return 1e9 * min(timeit.repeat(call, number=number, repeat=repeat)) / number / per


def in_rust(urdf: str, support: str) -> dict[str, tuple[float, float]]:
    """One posture and a batch, by function; empty where there is no cargo."""
    try:
        words = ["cargo", "bench", "--quiet", "--bench", "tape", "--", urdf, support]
        done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return {}
    rows = re.findall(r"^(\w+) +([0-9.]+) +([0-9.]+)$", done.stdout, flags=re.M)
    return {name: (float(one), float(batch)) for name, one, batch in rows}


def ours(model: sesc.Model, rust: dict[str, tuple[float, float]]) -> None:
    """One posture as one types it, `model.com(q)`; batches into an array that is there."""
    q = np.random.default_rng(1).uniform(-0.5, 0.5, (POSTURES, model.dof))
    one = q[0].copy()
    print(f"{'':18} {'one: Rust':>10} {'Python':>8} {'out=':>6}   {'batch: Rust':>11} {'Python':>8} {'ratio':>6} {'threads=2':>10}")
    for name, count in FUNCTIONS.items():
        call, many, single = getattr(model, name), [q] * count, [one] * count
        out, place = call(*many), call(*single)
        alone = least(lambda: call(*single), 200)
        into = least(lambda: call(*single, out=place), 200)
        batch = least(lambda: call(*many, out=out), 1, POSTURES)
        two = least(lambda: call(*many, out=out, threads=2), 1, POSTURES)
        theirs = rust.get(name, (np.nan, np.nan))
        print(
            f"{name:18} {theirs[0]:10.0f} {alone:8.0f} {into:6.0f}   {theirs[1]:11.1f} {batch:8.1f} "
            f"{batch / theirs[1]:6.2f} {two:10.1f}"
        )


def pinocchio(urdf: str) -> tuple[float, float, float]:
    """CoM, its Jacobian, and the rates of momentum, which a ZMP is made of."""
    import pinocchio as pin

    peer = pin.buildModelFromUrdf(urdf)
    data, q = peer.createData(), pin.neutral(peer)
    v, a = np.random.default_rng(1).uniform(-1, 1, (2, peer.nv))
    com = least(lambda: pin.centerOfMass(peer, data, q), 200)
    jacobian = least(lambda: pin.jacobianCenterOfMass(peer, data, q), 200)
    return com, jacobian, least(lambda: pin.computeCentroidalMomentumTimeVariation(peer, data, q, v, a), 200)


def mujoco(urdf: str) -> tuple[float, float]:
    import mujoco as mj

    peer = mj.MjModel.from_xml_path(urdf)
    data = mj.MjData(peer)
    jacobian = np.zeros((3, peer.nv))

    def com() -> None:
        mj.mj_kinematics(peer, data)
        mj.mj_comPos(peer, data)

    def com_jacobian() -> None:
        com()
        mj.mj_jacSubtreeCom(peer, data, jacobian, 1)

    return least(com, 200), least(com_jacobian, 200)


def adam(urdf: str) -> tuple[float, float]:
    from adam.casadi import KinDynComputations

    model = sesc.Robot(urdf)
    peer = KinDynComputations(urdf, model.joints)
    q = np.random.default_rng(1).uniform(-0.5, 0.5, (len(model.joints), FEW))
    base = np.tile(np.eye(4), (1, FEW))
    times = []
    for function in (peer.CoM_position_fun(), peer.CoM_jacobian_fun()):
        batch = function.map(FEW)
        times.append(least(lambda: batch(base, q), 1, FEW, 20))
    return times[0], times[1]


def fits(urdf: str, support: str) -> None:
    import pyarrow as pa
    import pyarrow.parquet as parquet

    robot = sesc.Robot(urdf)
    columns = sesc.simulate(robot.on(support), 1_000_000, range=0.5, noise=1e-4).columns()
    assert columns is not None
    table = pa.table(columns)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "log.parquet"
        parquet.write_table(table, file)
        command = [sys.executable, "-m", "sesc", "fit", urdf, "--support", support, "--data", str(file), "--json"]
        times: dict[str, Callable[[], Any]] = {
            "sesc.fit of a data frame": lambda: sesc.fit(robot, sesc.Log(table, support=support)),
            "sesc fit of Parquet": lambda: subprocess.run(command, check=True, capture_output=True),
        }
        for name, call in times.items():
            start, processor = time.perf_counter(), sum(os.times()[:4])
            call()
            taken, used = time.perf_counter() - start, sum(os.times()[:4]) - processor
            print(f"{name:28} {taken:6.2f} s, of processors {used:6.2f} s")


def main(arguments: list[str]) -> None:
    given = [word for word in arguments if not word.startswith("--")]
    urdf, support = given or [str(ROOT / "robots" / "op2" / "op2.urdf"), "r_sole"]
    ours(sesc.Robot(urdf).on(support), in_rust(urdf, support))
    peers: list[tuple[str, Callable[[str], tuple[float, ...]]]]
    peers = [("pinocchio", pinocchio), ("mujoco", mujoco), ("adam", adam)]
    print(f"\n{'':18} {'CoM':>10} {'Jacobian':>10} {'momentum':>10}")
    for name, peer in peers:
        try:
            importlib.import_module(name)
        except ImportError:
            continue
        print(f"{name:18} " + " ".join(f"{time:10.0f}" for time in peer(urdf)))
    if "--fit" in arguments:
        print()
        fits(urdf, support)


if __name__ == "__main__":
    main(sys.argv[1:])
