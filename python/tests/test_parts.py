"""Parts as bytes: small, of every format that was ever written."""

from __future__ import annotations

import numpy as np

import sesc

from conftest import repository

#: 40 readings of 20 postures of a pole of 2 kg, of the second format, and what was fitted then.
MONDAY = repository() / "identify" / "src" / "fit" / "part" / "monday-2.part"
FITTED = [0.1, -6.649317114344957e-08, 0.0, 1.957835096433806e-06, 0.9999909904061652]


def test_a_part_of_the_op2_is_80_kb_and_its_urdf(op2: sesc.Robot, model: sesc.Model) -> None:
    for postures in (100, 5000):
        part = sesc.gather(op2, sesc.simulate(model, postures, range=0.5, noise=1e-4))
        assert len(bytes(part)) <= 80_000 + len(op2.urdf)
        assert sesc.Part.from_bytes(bytes(part)) == part


def test_parts_of_deviations_of_their_own_keep_both_sums(op2: sesc.Robot, model: sesc.Model) -> None:
    log = sesc.simulate(model, 100, range=0.5, noise=1e-4)
    columns = dict(log.columns() or {})
    columns["cop_x_std"] = columns["cop_x_std"] * np.linspace(0.5, 2.0, 100)
    part = sesc.gather(op2, sesc.Log(columns, support="r_sole"))
    assert 160_000 < len(bytes(part)) <= 160_000 + len(op2.urdf)
    # One deviation first, then many: the same rows as all at once.
    more = sesc.gather(op2, sesc.simulate(model, 100, range=0.5, noise=1e-4, seed=2))
    np.testing.assert_allclose(sesc.fit(more | part).params, sesc.fit(part | more).params, atol=1e-12)


def test_parts_of_the_format_before_are_read() -> None:
    part = sesc.Part.from_bytes(MONDAY.read_bytes())
    assert part.postures == 20 and part.support == "foot"
    np.testing.assert_allclose(sesc.fit(part).params, FITTED, atol=1e-12)
