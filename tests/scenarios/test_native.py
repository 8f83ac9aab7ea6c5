"""Compiled and interpreted arithmetic give the same sail, to the last digit of the truth."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from companion import native

SAIL = """
import sys
from pathlib import Path
from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run
name, vessel, folder = sys.argv[1:]
changes = {"follow": {"time": "20"}, "fence_stop": {"by": "mission"}}.get(name, {})
run(SCENARIOS[name], LockstepRig, Path(folder), seed=0, vessel=vessel, changes=changes)
"""

# Rooms whose tests replace nothing of what is compiled, and look at values that pass through many types.
COMPILED_TOO = (
    "tests/replay",
    "tests/unit/record/test_mcap_log.py",
    "tests/unit/record/test_readings.py",
    "tests/unit/record/test_ulog.py",
    "tests/unit/io/mavlink/wire",
)

BUILT = bool(native.usable(native.ROOT, native.FOLDER)[0])


@pytest.mark.process
@pytest.mark.skipif(not BUILT, reason="no native build of these sources: `make native`")
@pytest.mark.parametrize(
    ("scenario", "vessel"),
    [
        ("docking", "revolt"),
        ("mission_square", "aboat"),
        ("follow", "rescuerunner"),
        ("fence_stop", "revolt"),
        ("obstacles", "otter"),
    ],
)
def test_both_sail_the_same(scenario: str, vessel: str, tmp_path: Path) -> None:
    logs = {}
    for wish in ("0", "require"):
        folder = tmp_path / wish
        command = [sys.executable, "-c", SAIL, scenario, vessel, str(folder)]
        done = subprocess.run(
            command, env={**os.environ, "USV_NATIVE": wish}, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        logs[wish] = folder
    for name in ("truth.csv", "ticks.csv", "events.csv"):
        assert (logs["0"] / name).read_bytes() == (logs["require"] / name).read_bytes()
    for name in ("log.mcap", "telemetry.tlog"):
        assert (logs["0"] / name).stat().st_size == (logs["require"] / name).stat().st_size


@pytest.mark.process
@pytest.mark.skipif(not BUILT, reason="no native build of these sources: `make native`")
def test_the_bench_can_time_it() -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/unit/test_bench_stopwatches.py"]
    environment = {**os.environ, "USV_NATIVE": "require"}
    done = subprocess.run(command, cwd=native.ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.process
@pytest.mark.skipif(not BUILT, reason="no native build of these sources: `make native`")
@pytest.mark.parametrize("room", COMPILED_TOO)
def test_its_values_are_those_of_the_interpreter(room: str) -> None:
    """An integer where `float` is written becomes a float, compiled: the log's readings came back as others."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not sweep", room]
    environment = {**os.environ, "USV_NATIVE": "require"}
    done = subprocess.run(command, cwd=native.ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
