"""The plans with which a recorded run began, as displays draw them."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path
from typing import Any

from companion.core.geodesy import LocalFrame
from companion.fence.chart import chart_of
from companion.record.recorder import STATE_FOLDER
from companion.record.state_file import StateFile


def chart_of_log(folder: Path, frame: LocalFrame) -> dict[str, Any]:
    """As `fence.chart.chart_of`. The state is read from a copy: reading it may set a bad file aside."""
    recorded = folder / STATE_FOLDER
    with tempfile.TemporaryDirectory() as place:
        copy = Path(place) / STATE_FOLDER
        if recorded.is_dir():
            shutil.copytree(recorded, copy)
        state = StateFile(copy)
        plans, _ = state.load_plans()
        state.close()
    return chart_of(plans, frame)
