"""Functions of the package beside the C that it writes, compiled and loaded, in one run:
nanoseconds a posture.

    pip install ./python
    CC=gcc python benches/compiled.py [URDF SUPPORT]     # the OP2 on its right sole unless given

What `model.compile()` would do by hand: C with vector types for the processor at hand, loaded by
ctypes, in batches of arrays that are there. The package and C take turns, and each number is the
least of many short repeats. `ordered` also brings positions and results into the order of numpy:
posture by posture, as the package has them.
"""

from __future__ import annotations

import ctypes
import os
import platform
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import sesc

POSTURES = 10_000
REPEATS = 100
#: Functions of the package: what C calls them, arrays that they take, and whether parameters.
FUNCTIONS = {
    "com": ("com", 1, True),
    "com_jacobian": ("com_jacobian", 1, True),
    "com_velocity": ("com_velocity", 2, True),
    "gravity_moments": ("gravity_moments", 1, True),
    "cop": ("cop", 1, True),
    "cop_rows": ("regressor_cop", 1, False),
    "com_rows": ("regressor", 1, False),
    "full_rows": ("regressor_full", 1, False),
    "zmp": ("zmp", 3, True),
}
#: Kinds of code: whether products and sums are rounded each by itself, and the processor.
KINDS = {
    "this processor, the bits of the package": (16, ["-ffp-contract=off", "-march=native"]),
    "this processor, fused products and sums": (16, ["-march=native"]),
    "AVX2, the bits of the package": (8, ["-ffp-contract=off", "-march=x86-64-v3"]),
}


def compiled(model: sesc.Model, folder: Path, lanes: int, flags: list[str]) -> tuple[Any, float]:
    """The library of a model's C, and how many seconds the compiler takes."""
    source = next(file for file in model.c99(folder, name="robot", lanes=lanes) if file.suffix == ".c")
    library = folder / f"robot{lanes}.so"
    words = [os.environ.get("CC", "gcc"), "-O3", *flags, "-shared", "-fPIC", "-o", str(library), str(source), "-lm"]
    start = time.perf_counter()
    subprocess.run(words, check=True)
    return ctypes.CDLL(str(library)), time.perf_counter() - start


def addresses(*arrays: np.ndarray[Any, Any]) -> list[Any]:
    return [array.ctypes.data_as(ctypes.c_void_p) for array in arrays]


def least(calls: list[Callable[[], object]]) -> list[float]:
    """Nanoseconds a posture of each call; they take turns."""
    best = [float("inf")] * len(calls)
    for _ in range(REPEATS):
        for k, call in enumerate(calls):
            start = time.perf_counter()
            call()
            best[k] = min(best[k], time.perf_counter() - start)
    return [1e9 * seconds / POSTURES for seconds in best]


def row(model: sesc.Model, library: Any, name: str) -> tuple[list[float], float]:
    """Times of the package, of C, and of C with the order of numpy; and the largest difference."""
    in_c, count, takes_parameters = FUNCTIONS[name]
    inputs = list(np.random.default_rng(1).uniform(-0.5, 0.5, (count, POSTURES, model.dof)))
    call = getattr(model, name)
    out = call(*inputs)
    joints = [np.ascontiguousarray(q.T) for q in inputs]
    found = np.zeros((out[0].size, POSTURES))
    parameters = [model.params] if takes_parameters else []
    words = addresses(*joints, *parameters, found)
    function = getattr(library, f"robot_{in_c}_batch")
    function.restype = None
    size, flat = ctypes.c_size_t(POSTURES), out.reshape(POSTURES, -1)

    def ordered() -> None:
        for q, joint in zip(inputs, joints, strict=True):
            joint[:] = q.T
        function(size, *words)
        flat[:] = found.T

    function(size, *words)
    apart = float(np.abs(found.T - flat).max())
    times = least([lambda: call(*inputs, out=out), lambda: function(size, *words), ordered])
    return times, apart


def processor() -> str:
    """The kind of processor, where the system says it."""
    try:
        found = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    except OSError:
        found = None
    return found[1] if found else platform.processor()


def main() -> None:
    urdf, support = sys.argv[1:3] if len(sys.argv) > 2 else (sesc.OP2_URDF, "r_sole")
    model = sesc.Robot(urdf).on(support)
    print(f"{processor()}; sesc {sesc.__version__}, {POSTURES} postures of {model.dof} joints, ns a posture")
    for kind, (lanes, flags) in KINDS.items():
        with tempfile.TemporaryDirectory() as folder:
            library, seconds = compiled(model, Path(folder), lanes, flags)
            print(f"\n{kind}, compiled in {seconds:.1f} s\n{'':16} package     C  ratio  ordered  ratio  difference")
            for name in FUNCTIONS:
                (package, c, ordered), apart = row(model, library, name)
                print(
                    f"{name:16} {package:7.1f} {c:5.1f} {package / c:6.2f} {ordered:8.1f} {package / ordered:6.2f}"
                    f"  {apart:10.1e}"
                )


if __name__ == "__main__":
    main()
