"""Functions from Python beside the same calls in other packages: nanoseconds a posture.

    python benches/python.py robots/op2/op2.urdf r_sole

Each number is the least of several repeats. Pinocchio and MuJoCo are measured where they are
installed; they have no batches, so that a loop in Python is what their users write.
"""

from __future__ import annotations

import sys
import timeit
from collections.abc import Callable

import numpy as np

import sesc

POSTURES = 100_000


def least(call: Callable[[], object], number: int) -> float:
    """Seconds of one call."""
    return min(timeit.repeat(call, number=number, repeat=5)) / number


def main(urdf: str, support: str) -> None:
    model = sesc.Robot(urdf).on(support)
    rng = np.random.default_rng(1)
    q = rng.uniform(-0.5, 0.5, (POSTURES, model.dof))
    one = q[0].copy()
    print(f"{'':24} {'batch, ns':>10} {'threads=2':>10} {'one, ns':>10}")
    for name in ("com", "com_jacobian", "gravity_moments", "cop", "cop_rows", "com_rows"):
        call = getattr(model, name)
        out, place = call(q), call(one)
        times = [
            least(lambda: call(q, out=out), 1) / POSTURES,
            least(lambda: call(q, out=out, threads=2), 1) / POSTURES,
            least(lambda: call(one, out=place), 10_000),
        ]
        print(f"{name:24}" + "".join(f" {1e9 * t:10.1f}" for t in times))
    try:
        import pinocchio as pin
    except ImportError:
        return
    peer = pin.buildModelFromUrdf(urdf)
    data, theirs = peer.createData(), np.zeros(peer.nq)
    print(f"{'pinocchio, com':24} {'':10} {'':10} {1e9 * least(lambda: pin.centerOfMass(peer, data, theirs), 10_000):10.1f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
