"""Integrals over even and uneven steps."""

from __future__ import annotations

import numpy as np
import pytest

from companion.guidance.steps import Steps


def test_even_and_uneven_steps_tell_the_same() -> None:
    even = np.linspace(2.0, 12.0, 21)
    uneven = np.unique(np.concatenate((even, np.linspace(3.0, 4.0, 37), [7.1, 7.1001])))
    low, high = np.array([2.0, 2.2, 3.33, 12.0]), np.array([12.0, 2.3, 7.1, 12.0])
    values = np.sin(even)
    by_even = Steps(even, 0.5).integral(values, low, high)
    assert Steps(uneven, None).integral(np.interp(uneven, even, values), low, high) == pytest.approx(by_even)
    assert Steps(even, 0.5).integral(3.0 * even, low, high) == pytest.approx(1.5 * (high**2 - low**2))
