"""`make bench`: speeds as medians and ratios, without assertions, since the machine may be shared.

Steps are timed in processor time, which other processes do not change. Transfers and the start use the wall clock.
"""

from __future__ import annotations

import gc
import json
import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any

from companion import native
from companion.allocation.allocator import Allocator
from companion.app import load_vessel
from companion.baselines.ahrs import ThesisAhrs
from companion.cli.rig import LockstepRig
from companion.config.devices import SensorConfig
from companion.control.controller import Controller
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import NO_ESTIMATE
from companion.core.geodesy import LocalFrame
from companion.core.readings import LeaderState
from companion.core.setpoint import PATH_STEP_S, PathSetpoint, PlannedPose
from companion.core.tick import Tick
from companion.core.work import AtOnce
from companion.following.law import FollowLaw
from companion.following.tracker import LeaderTracker
from companion.guidance.path import PathKind, build_path
from companion.io.sensors import open_sensor
from companion.nav.ahrs import Ahrs
from companion.nav.error_state import ErrorStateFilter
from companion.params.store import Parameters
from companion.record.recorder import LogFolder
from sitl.scenarios import SCENARIOS
from sitl.scenarios.convoy import Convoy
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import run as run_scenario
from sitl.shared_sea import LeadBoatConfig
from tests import bench_console, bench_control_thread, bench_reference, bench_requests
from tests.bench_stopwatches import ControlStep, GarbageCollector, TimedVessel, time_control_steps, time_world
from tests.protocol.lead_boat_module import Pair, circle

_HOLD = 0x03040000


_speeds: dict[str, float] = {}
_interpreted: dict[str, float] = {}
_before: dict[str, float] = {}  # speeds of the newest kept commit, on this machine as it is now
_before_commit = ""


def line(what: str, value: str, aim: str, speed: float | None = None) -> None:
    """Print one row: what, measured, target. `speed`: a number that grows as this gets faster; its row ends with the
    ratios to that of interpreted arithmetic and of the newest kept commit, where they exist."""
    ratios = ""
    if speed is not None:
        _speeds[what] = speed
        ratios += f", {speed / _interpreted[what]:.2f} × interpreted" if what in _interpreted else ""
        ratios += f", {speed / _before[what]:.2f} × {_before_commit}" if what in _before else ""
    print(f"{what:58} {value:>28}   aim {aim}{ratios}", flush=True)


def median_and_p99_us(call: Callable[[], Any], calls: int = 5000) -> str:
    """Processor time of single calls. Reading the clock takes a third of a microsecond of it."""
    times_s = []
    for _ in range(calls):
        started_s = time.thread_time()
        call()
        times_s.append(time.thread_time() - started_s)
    times_s.sort()
    return f"median {1e6 * times_s[calls // 2]:.1f} µs, p99 {1e6 * times_s[calls * 99 // 100]:.1f} µs"


def blocks() -> None:
    """The arithmetic alone: what the control thread computes in a tick, without bytes, links and log."""
    eskf = ErrorStateFilter(9.82)
    eskf.start((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.01, 0.02, 0.5), [0.1] * 6 + [0.03] * 3 + [0.05] * 3 + [0.0035] * 3)

    def fuse_position_heading() -> None:
        eskf.fuse(eskf.position_innovation(eskf.position[0] + 0.01, eskf.position[1], (-0.8, 0.0, -0.2), 9e-4, 0.02))
        eskf.fuse(eskf.heading_innovation(0.5, 1e-4))

    samples = cycle([((0.1 * k, -0.1, -9.82), (0.01, 0.0, 0.002 * k), 0.01) for k in range(-3, 4)])
    line("ESKF: one IMU sample", median_and_p99_us(lambda: eskf.predict(*next(samples))), "100 µs")
    line("ESKF: position and heading", median_and_p99_us(fuse_position_heading), "100 µs")
    ahrs()
    config = load_vessel("revolt")
    allocator = Allocator(config, Parameters(config.parameters))
    demands = cycle(
        [Wrench(8.0 * math.sin(0.01 * k), 4.0 * math.cos(0.013 * k), 3.0 * math.sin(0.007 * k)) for k in range(2000)]
    )
    follower_step()
    line("allocation, three thrusters", median_and_p99_us(lambda: allocator.update(next(demands), 0.1)), "-")
    path_laws()


def path_laws() -> None:
    """The wrench along a planned path, a circle of 10 m, by each law."""
    config = load_vessel("aboat")
    turns = [0.1 * PATH_STEP_S * k for k in range(19)]
    ahead = tuple(PlannedPose(10.0 * math.sin(turn), 10.0 * (1.0 - math.cos(turn)), turn) for turn in turns)
    setpoint = PathSetpoint(0.0, 1.0, yaw_rate_radps=0.1, exact=True, ahead=ahead)
    nav = replace(NO_ESTIMATE, surge_mps=1.0, yaw_rate_radps=0.1)
    for value, name in enumerate(("loops", "LQR", "MPC")):
        controller = Controller(config, Parameters({**config.parameters, "PATH_CTRL": value}))
        timed = median_and_p99_us(partial(controller.update, setpoint, nav, ZERO_WRENCH, 0.1), 500)
        line(f"path law: {name}", timed, "-")


def follower_step() -> None:
    """What a follower computes in a tick beyond other modes: filter of the leader, its track, the law."""
    config = load_vessel("rescuerunner")
    parameters = Parameters(config.parameters)
    tracker, law = LeaderTracker(), FollowLaw(config, parameters, can_reverse=False)
    frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
    ticks = iter(range(10**9))
    nav = NO_ESTIMATE

    def step() -> None:
        t_s = 0.05 * next(ticks)
        course = 0.3 * math.sin(0.2 * t_s)
        lat_deg, lon_deg = frame.to_geodetic(8.0 * t_s, 10.0 * math.sin(0.2 * t_s))
        velocity = 8.0 * math.cos(course), 8.0 * math.sin(course)
        tracker.take(
            LeaderState(t_s, t_s, "bench", 7, lat_deg, lon_deg, *velocity, course, 0.06 * math.cos(0.2 * t_s), 1.0)
        )
        leader = tracker.leader(frame, t_s)
        assert leader is not None
        here = replace(
            nav,
            north_m=8.0 * t_s - 20.0,
            east_m=10.0 * math.sin(0.2 * t_s - 0.5),
            yaw_rad=course,
            surge_mps=8.0,
            north_mps=8.0,
        )
        if t_s == 0.0:
            law.start(here, leader, (20.0, math.pi), t_s)
        law.setpoint(law.update(here, leader, (20.0, math.pi), t_s), here, 0.05)

    median_and_p99_us(step, 500)
    line("follower: filter, track, law", median_and_p99_us(step), "1000 µs")


def ahrs() -> None:
    """One inertial sample of 200 Hz, with the magnetometer at 50 Hz and the receiver at 10 Hz."""
    for what, law in (("AHRS step, 200 Hz, all sensors", Ahrs(9.82)), ("  the thesis's filter", ThesisAhrs(9.82))):
        samples = iter(range(10**9))

        def step(filter_: Ahrs | ThesisAhrs = law, samples: Iterator[int] = samples) -> None:
            k = next(samples)
            filter_.sample(0.005 * k, (0.3, -0.1, -9.81), (0.01, 0.02, 0.001 * (k % 7)))
            if k % 4 == 0:
                filter_.magnetic(0.005 * k, (0.34, 0.02, 0.94), 0.09)
            if k % 20 == 0:
                filter_.velocity(0.005 * k, 5.0, 0.1, 0.06, (-0.8, 0.0, -1.0))

        median_and_p99_us(step, 500)
        line(what, median_and_p99_us(step), "100 µs")


def control_step(folder: Path, duration_s: float = 120.0) -> None:
    """From estimate to gate, of one vessel that holds in wind."""
    rig = LockstepRig(Conditions("revolt", seed=1, wind="2"), folder / "control_step")
    station = _armed_in_hold(rig)
    step = time_control_steps(rig.vessel)
    station.sail(duration_s)
    rig.close()
    times_s = sorted(step.ticks_s)
    text = f"median {1e3 * statistics.median(times_s):.2f} ms, p99 {1e3 * times_s[len(times_s) * 99 // 100]:.2f} ms"
    line("control step: estimate to gate", text, "p99 under 1 ms", 1.0 / statistics.median(times_s))


def _armed_in_hold(rig: LockstepRig) -> GroundStation:
    station = GroundStation(rig)
    station.ready()
    station.set_mode(_HOLD)
    station.arm()
    return station


class _Kept:
    """A recorder that keeps the ticks."""

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def record(self, tick: Tick) -> None:
        """Keep it."""
        self.ticks.append(tick)

    def close(self) -> None:
        """Nothing is open."""


def encoding(folder: Path, duration_s: float = 60.0, rounds: int = 5) -> None:
    """What the log of a hold costs: its readings, ticks and rows, without the medium's time."""
    rig, kept = LockstepRig(Conditions("revolt", seed=1, wind="2"), folder / "sailed"), _Kept()
    rig.vessel.add_recorder(kept)
    station = GroundStation(rig)
    station.ready()
    station.sail(duration_s)
    rig.close()
    thrusters = [row.name for row in rig.config.thrusters]
    devices = [*(row.name for row in rig.config.sensors), *(row.name for row in rig.config.actuators)]
    times_ms = []
    for n in range(rounds):
        log = LogFolder(folder / f"log{n}", thrusters, devices, {})
        started_s = time.thread_time()
        for tick in kept.ticks:
            log.record(tick)
        times_ms.append(1e3 * (time.thread_time() - started_s) / len(kept.ticks))
        log.close()
    readings = sum(len(tick.readings) for tick in kept.ticks) / len(kept.ticks)
    line(
        f"log of a tick with {readings:.0f} readings",
        bench_requests.median_and_range(times_ms, ".3f") + " ms",
        "0.15 ms",
    )


def lockstep(folder: Path, duration_s: float = 600.0) -> None:
    """Hold in wind with everything on: bytes, plant, estimator, telemetry, log."""
    rig = LockstepRig(Conditions("revolt", seed=1, wind="2"), folder / "lockstep")
    station = _armed_in_hold(rig)
    collector = GarbageCollector()
    ticks: list[tuple[float, float]] = []
    world = time_world(rig.vessel, collector.take)  # what the plant's steps collect is not the tick's

    def took(_: str, tick_s: float) -> None:
        ticks.append((tick_s, collector.take()))

    rig.vessel = TimedVessel(rig.vessel, world, took)  # type: ignore[assignment]
    from_s = rig.now_s
    started_s, cpu_started_s = time.perf_counter(), time.process_time()
    with collector:
        station.sail(duration_s)
    took_s, cpu_took_s = time.perf_counter() - started_s, time.process_time() - cpu_started_s
    sailed_s = rig.now_s - from_s
    rig.close()
    rate = f"{sailed_s / cpu_took_s:.0f} × real time (wall {sailed_s / took_s:.0f})"
    line("lockstep, whole stack, one core", rate, "200 ×", sailed_s / cpu_took_s)
    text = f"{1e3 * world.took_s / sailed_s:.1f} ms a boat second"
    line("  of which plant and emulators", text, "-", 1.0 / world.took_s * sailed_s)
    steps_s = sorted(tick_s for tick_s, _ in ticks)
    p99_s = steps_s[int(0.99 * len(steps_s))]
    text = f"median {1e3 * statistics.median(steps_s):.2f} ms, p99 {1e3 * p99_s:.2f} ms"
    line("tick without the plant", text, "0.35 ms, 0.7 ms", 1.0 / statistics.median(steps_s))
    worst_s, collected_s = max(ticks)
    text = f"{1e3 * worst_s:.1f} ms, of it {1e3 * collected_s:.1f} ms garbage"
    line(f"  the worst in {duration_s / 60.0:.0f} minutes", text, "3 ms")
    text = f"{100 * sum(steps_s) / sailed_s:.2f} % of a core"
    line("on-board part at real time", text, "0.5 %", sailed_s / sum(steps_s))


def obstacles(folder: Path, seed: int = 21) -> None:
    """A mission through a field of obstacles that a lidar sees: a tick's control step with the guard, and the looks for
    a way round that the worker does on a boat."""
    plans_s: list[float] = []
    steps: list[ControlStep] = []

    def rig(conditions: Conditions, folder: Path) -> LockstepRig:
        made = LockstepRig(conditions, folder)
        steps.append(time_control_steps(made.vessel))
        made.vessel.supervisor.parts.obstacles.work_with(_TimedWorker(plans_s, steps[0].leave_out))
        return made

    gc.disable()  # of the simulation's objects, which a boat does not have
    try:
        outcome = run_scenario(SCENARIOS["obstacles"], rig, folder, seed=seed)
    finally:
        gc.enable()
    assert outcome.error is None
    steps_s = sorted(steps[0].ticks_s)
    p99_s = steps_s[int(0.99 * len(steps_s))]
    text = f"p99 {1e3 * p99_s:.1f} ms, worst {1e3 * steps_s[-1]:.1f} ms"
    line("control step among obstacles", text, "worst under 20 ms")
    text = bench_requests.median_and_range([1e3 * s for s in plans_s], ".0f") + " ms"
    line("  a look for a way round, beside", text, "-")


class _TimedWorker:
    """A worker that works at once, notes how long, and tells it to `took`."""

    def __init__(self, times_s: list[float], took: Callable[[float], None]) -> None:
        self._times_s, self._took = times_s, took

    def submit(self, work: Callable[[], Any], urgent: bool = False) -> Any:
        """As `Worker.submit`."""
        started_s = time.thread_time()
        future = AtOnce().submit(work)
        self._times_s.append(time.thread_time() - started_s)
        self._took(self._times_s[-1])
        return future


def following(folder: Path, followers: int, duration_s: float = 30.0) -> None:
    """Jet boats in Follow behind a lead boat, in one process: its module and control at 20 Hz, inertial sensors at 200
    Hz."""
    settings = SCENARIOS["follow"].defaults
    leader = LeadBoatConfig("leader", "thesis", (20.0, 0.0, 0.0))
    conditions = Conditions(
        "rescuerunner", seed=1, wind="5", gnss="standalone", lead_boats=(leader,), start=(0.0, 0.0, 0.0)
    )
    rigs = [LockstepRig(conditions, folder / f"following{followers}")]
    for number in range(2, followers + 1):
        own = {"MAV_SYS_ID": float(number), "FLW_TGT_DST": 25.0 * number}
        rigs.append(
            rigs[0].second_vessel(
                replace(conditions, seed=number, start=(-25.0 * (number - 1), 0.0, 0.0), parameters=own),
                f"follower{number}",
            )
        )
    convoy = Convoy(rigs, settings)
    convoy.follow()
    convoy.boat.depart(convoy.now_s)
    convoy.sail(5.0)
    cpu_started_s = time.process_time()
    convoy.sail(duration_s)
    cpu_took_s = time.process_time() - cpu_started_s
    for rig in rigs:
        rig.close()
    what = "a jet boat" if followers == 1 else f"{followers} jet boats"
    line(
        f"{what} following a lead boat in lockstep",
        f"{duration_s / cpu_took_s:.0f} × real time, one core",
        "100 ×" if followers == 1 else "-",
        duration_s / cpu_took_s,
    )


def leader_link(folder: Path, duration_s: float = 60.0) -> None:
    """A leader module and its follower on a narrow line, in lockstep, with all their messages."""
    pair = Pair(folder / "leader_link", circle)
    pair.run(8.0)
    pair.bytes_up = pair.bytes_down = 0
    started_s = time.process_time()
    pair.run(duration_s)
    took_s = time.process_time() - started_s
    up, down = pair.bytes_up / duration_s, pair.bytes_down / duration_s
    pair.close()
    line(
        "leader module's link at 20 Hz, there and back",
        f"{up:.0f} + {down:.0f} = {up + down:.0f} bytes/s",
        "2000 bytes/s",
    )
    line("leader module and follower in lockstep", f"{duration_s / took_s:.0f} × real time, one core", "-")


def paths(points: int = 10_000) -> None:
    """Processor time of the curves through a mission."""
    route = [(3.0 * k + 3.0 * math.sin(k), k + 8.0 * math.cos(0.7 * k)) for k in range(points)]
    for kind in PathKind:
        builds_s = []
        for _ in range(5):
            started_s = time.process_time()
            path = build_path(route, kind)
            builds_s.append(time.process_time() - started_s)
        places = [(path.position(s), s) for s in (path.length_m * k / 5000 for k in range(5000))]
        started_s = time.process_time()
        for (north_m, east_m), s in places:
            path.project(north_m + 0.5, east_m - 0.3, s - 0.3, 6.0)
        project_us = 1e6 * (time.process_time() - started_s) / len(places)
        line(
            f"path of {points} waypoints, {kind.name.lower()}",
            f"{1e3 * statistics.median(builds_s):.0f} ms, {project_us:.0f} us a projection",
            "50 ms, 20 us",
        )


def sensors(seconds: int = 20) -> None:
    """Reading a receiver (six sentences, 20 Hz) and inertial sensors (200 Hz), with health at 10 Hz."""
    from tests.unit.io.sensors.test_mavlink_imu import HEARTBEAT, HIGHRES
    from tests.unit.io.sensors.test_mtdata2 import BY_HAND
    from tests.unit.io.sensors.test_nmea0183 import GGA, HDT, RMC, VTG, ZDA, sentence
    from tests.unit.io.sensors.test_vectornav import VNYMR
    from tests.wires import Listening

    gst = sentence("GNGST,120000.00,1.2,0.020,0.010,45.0,0.012,0.016,0.030")
    loads = {
        "nmea0183": (20, GGA + HDT + VTG + ZDA + gst + RMC),
        "mtdata2": (200, BY_HAND),
        "vectornav": (200, VNYMR),
        "mavlink_imu": (200, HIGHRES),
    }
    for driver, (rate_hz, data) in loads.items():
        stream = Listening()
        sensor = open_sensor(SensorConfig("sensor", driver, "serial:/dev/x", rate_hz=rate_hz), stream)
        stream.chunks = [(0.0, HEARTBEAT)]
        sensor.read(0.0)
        started_s = time.process_time()
        for k in range(1, seconds * rate_hz):
            stream.chunks = [(k / rate_hz, data)]
            sensor.read(k / rate_hz)
            if k % (rate_hz // 10) == 0:
                sensor.health(k / rate_hz)
        share = (time.process_time() - started_s) / seconds
        line(f"{driver} at {rate_hz} Hz", f"{100.0 * share:.2f} % of a core", "1 %")


def _speeds_interpreted() -> dict[str, float]:
    """The speeds of a process with interpreted arithmetic; none where this one's is."""
    if not native.status.startswith("native"):
        return {}
    command = [sys.executable, "-m", "tests.bench", "--speeds"]
    environment = {**os.environ, "USV_NATIVE": "0"}
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True)
    speeds: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return speeds


def _remember() -> None:
    """What the newest kept commit would do on this machine now, by the reference loop."""
    global _before_commit
    if (row := bench_reference.newest()) is not None:
        reference_s, _before_commit = bench_reference.reference_s(), row["commit"]
        _before.update({what: speed / reference_s for what, speed in row["speeds"].items()})


def speeds() -> None:
    """The rows that have a speed."""
    with tempfile.TemporaryDirectory() as name:
        control_step(Path(name), 60.0)
        lockstep(Path(name), 60.0)
        following(Path(name), 1)


def main() -> None:
    """Print all figures; with --speeds only some, and as the last line the speeds for the process that compares; with
    --keep these, and store them for the trend."""
    _remember()
    if "--keep" in sys.argv:
        reference_s = bench_reference.reference_s()
        speeds()
        bench_reference.keep(_speeds, min(reference_s, bench_reference.reference_s()))
        return
    if "--speeds" in sys.argv:
        speeds()
        print(json.dumps(_speeds))
        return
    _interpreted.update(_speeds_interpreted())
    print(f"Python {sys.version.split()[0]}, {os.cpu_count()} cores; arithmetic: {native.status}")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        blocks()
        paths()
        sensors()
        control_step(folder)
        encoding(folder / "encoding")
        lockstep(folder)
        obstacles(folder / "obstacles")
        following(folder, 1)
        following(folder, 2)
        leader_link(folder)
        bench_control_thread.most_at_a_time(folder, line)
        bench_console.feed_cost(folder, line)
        bench_console.console(folder, line)
        bench_requests.start_up(folder, line)
        bench_requests.transfers(folder, line)
    line(
        "peak memory of this bench process", f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB", "-"
    )


if __name__ == "__main__":
    main()
