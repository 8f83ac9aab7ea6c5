"""A newcomer's path from a tape measure to Hold with an identified boat; `newcomer.py` sails it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.protocol.newcomer import sail

pytestmark = [pytest.mark.process, pytest.mark.sweep]  # two minutes and a half


def test_an_afternoon_is_enough(tmp_path: Path) -> None:
    sailed = sail(tmp_path, 10.0)
    assert sailed.trial_min < 15.0 and sailed.whole_min < 30.0
    assert sailed.worst_m < 2.0 * sailed.length_m
    assert not [text for text in sailed.texts if "failed" in text]
