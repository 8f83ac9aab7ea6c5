"""The controller's model against matrices and against the thesis's numbers."""

from __future__ import annotations

import numpy as np
import pytest

from companion.config.hull import DampingConfig, HullConfig
from companion.control.model import coriolis, damping, force_for

HULL = HullConfig(
    263.93, 306.44, 322.15, 7.0, 7.03, DampingConfig(x_u=50.66, y_v=601.45, y_r=83.05, n_v=83.10, n_r=268.17)
)


def test_against_matrices_with_the_thesis_numbers() -> None:
    m = np.array([[263.93, 0, 0], [0, 306.44, 7.0], [0, 7.03, 322.15]])
    d = np.array([[50.66, 0, 0], [0, 601.45, 83.05], [0, 83.10, 268.17]])
    rng = np.random.default_rng(1)
    for _ in range(20):
        nu, acceleration = rng.normal(size=3), rng.normal(size=3)
        u, v, r = nu
        c = np.array([[0, 0, -(306.44 * v + 7.0 * r)], [0, 0, 263.93 * u], [306.44 * v + 7.0 * r, -263.93 * u, 0]])
        wrench = force_for(HULL, *nu.tolist(), *acceleration.tolist())
        assert [wrench.surge_n, wrench.sway_n, wrench.yaw_nm] == pytest.approx(list(m @ acceleration + c @ nu + d @ nu))


def test_coriolis_does_no_work() -> None:
    u, v, r = 0.4, -0.2, 0.1
    x, y, n = coriolis(HULL, u, v, r)
    assert x * u + y * v + n * r == pytest.approx(0.0, abs=1e-12)


def test_nonlinear_damping_is_odd_and_resists() -> None:
    hull = HullConfig(
        1.0,
        1.0,
        1.0,
        damping=DampingConfig(
            x_u=1,
            x_uu=2,
            x_uuu=3,
            y_v=1,
            y_vv=2,
            y_rv=3,
            y_r=4,
            y_vr=5,
            y_rr=6,
            n_v=1,
            n_vv=2,
            n_rv=3,
            n_r=4,
            n_vr=5,
            n_rr=6,
        ),
    )
    ahead, astern = damping(hull, 0.5, 0.3, 0.2), damping(hull, -0.5, -0.3, -0.2)
    assert ahead == pytest.approx(tuple(-f for f in astern))
    assert ahead[0] == pytest.approx(1 * 0.5 + 2 * 0.25 + 3 * 0.125)
    assert ahead[1] == pytest.approx((1 + 2 * 0.3 + 3 * 0.2) * 0.3 + (4 + 5 * 0.3 + 6 * 0.2) * 0.2)
