"""The stopwatches of `make bench` need no method that is replaced: they work with compiled classes too."""

from __future__ import annotations

from pathlib import Path

from companion.cli.rig import LockstepRig
from sitl.scenarios.rig import Conditions
from tests.bench_stopwatches import GarbageCollector, TimedVessel, time_control_steps, time_world


def test_every_tick_is_timed_without_its_plant(tmp_path: Path) -> None:
    rig = LockstepRig(Conditions("revolt", seed=1), tmp_path)
    ticks: list[float] = []
    step = time_control_steps(rig.vessel)
    world = time_world(rig.vessel)
    rig.vessel = TimedVessel(rig.vessel, world, lambda _, took_s: ticks.append(took_s))  # type: ignore[assignment]
    with GarbageCollector():
        for _ in range(5):
            rig.step()
    rig.close()
    assert len(ticks) == len(step.ticks_s) == 5
    assert world.took_s > 0.0
    assert all(0.0 < control_s < tick_s for control_s, tick_s in zip(step.ticks_s, ticks, strict=True))


def test_work_beside_is_left_out(tmp_path: Path) -> None:
    rig = LockstepRig(Conditions("revolt", seed=1), tmp_path)
    step = time_control_steps(rig.vessel)
    step.begin()
    step.leave_out(1000.0)
    step.end()
    step.end()
    rig.close()
    assert step.ticks_s[0] < 0.0
    assert len(step.ticks_s) == 1
