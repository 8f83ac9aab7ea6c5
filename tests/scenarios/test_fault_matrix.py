"""The fault matrix: every fault in every mode on every vessel, as `sitl/fault_matrix/expected.toml` expects it.

`make scenarios` runs all cells; a few that cover vessels, groups of modes and groups of faults run always. A red cell
is told with its reason in the table, and fails here once it is green.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.config.vessel import bundled
from sitl.fault_matrix.cell import Observed, judge, run_stage
from sitl.fault_matrix.table import load

TABLE = load()
SAMPLE = {  # some seconds of processor time in all
    ("revolt", "Mission"): ("aground", "capsized"),
    ("cybership2", "Hold"): ("gnss_lost", "bridge_garbled", "leak", "process_stopped", "disk_full"),
    ("heron", "Circle"): ("thruster_fouled",),
    ("otter", "Manual"): ("sticks_silent", "imu_stuck", "safe_switch_silent"),
    ("cybership2", "Follow"): ("leader_lying",),
}


def not_as_expected(seen: list[Observed]) -> dict[str, list[str]]:
    """By fault: what is wrong, but for what is known to be; and what is known to be wrong and is not."""
    found = {}
    for one in seen:
        known = TABLE.expected(one.vessel, one.mode, TABLE.fault(one.fault)).red
        problems = judge(TABLE, one)
        if bool(problems) is not bool(known):
            found[one.fault] = problems or [f"green, although the table says: {known}"]
    return found


@pytest.mark.parametrize("stage", list(SAMPLE), ids=" ".join)
def test_some_cells(stage: tuple[str, str], tmp_path: Path) -> None:
    faults = [TABLE.fault(name) for name in SAMPLE[stage]]
    assert not not_as_expected(run_stage(TABLE, *stage, LockstepRig, tmp_path, faults))


@pytest.mark.sweep
def test_every_bundled_vessel_is_in_the_matrix() -> None:
    named = {row.name for row in TABLE.vessels}
    assert {*named, *TABLE.open_vessels} == set(bundled()) and not named & set(TABLE.open_vessels)


@pytest.mark.sweep
@pytest.mark.parametrize("stage", list(TABLE.stages()), ids=" ".join)
def test_all_cells(stage: tuple[str, str], tmp_path: Path) -> None:
    assert not not_as_expected(run_stage(TABLE, *stage, LockstepRig, tmp_path))
