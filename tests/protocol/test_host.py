"""The boat on a computer that fails it: late ticks, a clock that jumps, a medium that turns read-only."""

from __future__ import annotations

import errno
import os
import re
import resource
import signal
import socket
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.core.actuation import ZERO_WRENCH
from companion.core.readings import GnssFix
from companion.core.tick import COMPUTER, STORAGE
from companion.io.host import HostWatch
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.links import MemoryLink
from companion.io.sensors.mtdata2 import Mtdata2Sensor
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions
from tests.afloat_beside import BoatBeside
from tests.faulty_disk import FaultyDisk
from tests.protocol.desk import Desk, of
from tests.protocol.process import Companion
from tests.waiting import CAP_S, wait_until


class SteppingClock(SimulatedClock):
    """Its time of day jumps; the time that the boat lives by does not."""

    step_ns = 0

    def time_unix_ns(self) -> int:
        return super().time_unix_ns() + self.step_ns


class Boat:
    """What a `Desk` needs of a rig, with a clock of the test's."""

    def __init__(self, folder: Path) -> None:
        config = load_vessel("revolt")
        world, self.clock = World(config, WorldConditions(seed=3)), SteppingClock(EPOCH_UNIX_NS)
        self._link = MemoryLink("memory:desk")
        self.vessel = build(config, Surroundings(self.clock, world, world, [self._link], None, folder / "log"))
        watch = HostWatch(self.vessel.events.say)
        self.vessel.add_recorder(watch)
        self.due_s = 0.0

    @property
    def now_s(self) -> float:
        return self.clock.now_s()

    def step(self, late_s: float = 0.0) -> None:
        self.due_s += late_s
        self.clock.wait(self.due_s, ())
        self.vessel.tick(self.clock.now_s())
        self.due_s += self.vessel.period_s

    def send(self, data: bytes) -> None:
        self._link.to_vessel(data)

    def receive(self) -> bytes:
        return self._link.from_vessel()

    def close(self) -> None:
        self.vessel.close()


def holding(folder: Path) -> tuple[Desk, Boat]:
    boat = Boat(folder)
    desk = Desk(folder, boat)  # type: ignore[arg-type]
    desk.ready()
    assert desk.result(400, 1.0) == 0 and desk.result(176, 1.0, 4.0, 3.0) == 0
    desk.tick(10)
    return desk, boat


def test_an_hour_forth_and_back_changes_nothing_but_the_times_of_day(tmp_path: Path) -> None:
    rows: dict[bool, list[str]] = {}
    for stepped in (False, True):
        desk, boat = holding(tmp_path / str(stepped))
        for step_ns in (0, 3_600_000_000_000, -3_600_000_000_000):
            boat.clock.step_ns = step_ns if stepped else 0
            desk.heartbeat()
            desk.tick(8)
        desk.close()
        lines = (tmp_path / str(stepped) / "log" / "ticks.csv").read_text(encoding="utf-8").splitlines()
        place = lines[0].split(",").index("time_unix_ns")
        rows[stepped] = [",".join((*line.split(",")[:place], *line.split(",")[place + 1 :])) for line in lines]
        said = [text for text in desk.texts() if "clock stepped" in text]
        assert said == (
            ["Computer's clock stepped by +3600 s", "Computer's clock stepped by -7200 s"] if stepped else []
        )
    assert rows[True] == rows[False] and len(rows[True]) > 40


def test_late_ticks_are_told_stop_the_thrusters_and_end_by_themselves(tmp_path: Path) -> None:
    desk, boat = holding(tmp_path)
    for _ in range(6):
        boat.step(late_s=0.4)
    tick: Any = boat.vessel.last_tick
    assert "ticks_late" in tick.status.failsafes and tick.status.armed
    assert tick.allocation.achieved == ZERO_WRENCH
    assert [device.text for device in tick.health if device.name == COMPUTER] == ["ticks up to 0.4 s late"]
    desk.heartbeat()
    desk.tick(40)
    tick = boat.vessel.last_tick
    assert "ticks_late" not in tick.status.failsafes and tick.allocation.achieved != ZERO_WRENCH
    texts = desk.texts()
    assert any(text.startswith("Computer too slow: ticks 0.4 s late") for text in texts)
    assert any("Computer keeps up again" in text for text in texts)
    desk.close()


def test_a_medium_that_turns_read_only_stops_no_boat(tmp_path: Path) -> None:
    disk = FaultyDisk()
    desk = Desk(tmp_path, BoatBeside(tmp_path, disk))  # type: ignore[arg-type]
    desk.ready()
    disk.fail_with(errno.EROFS)
    desk.tell(mavlink.MAVLink_param_set_message(1, 1, b"WP_SPEED", 0.75, 9))
    storage: Any = desk.vessel.storage
    wait_until(lambda: not storage.parameters().pending, "the refusal of the medium")
    desk.tick()
    assert of(desk.received, "PARAM_ERROR") and desk.vessel.parameters["WP_SPEED"] == 0.75
    assert desk.result(400, 1.0) == 0, "it sails all the same"
    desk.tick()
    tick: Any = desk.vessel.last_tick
    (health,) = (device for device in tick.health if device.name == STORAGE)
    assert not health.ok and "Read-only file system" in health.text
    disk.fail_with(None)
    wait_until(lambda: storage.parameters().durable, "the value is on the medium at last")
    desk.tick()
    assert of(desk.received, "PARAM_VALUE")
    assert "parameters.json" not in storage.health(desk.rig.now_s)[0].text
    desk.close()


def failing(*_: Any) -> Any:
    raise ZeroDivisionError("float division by zero")


def starving(*_: Any) -> Any:
    raise MemoryError


@pytest.mark.parametrize(
    ("step", "fails", "error", "text", "told_in_full"),
    [
        ("sense", starving, MemoryError, "Computer: out of memory, a tick is left out", 0),
        ("allocate", failing, ZeroDivisionError, r"Tick left out: ZeroDivisionError, test_host\.py:\d+", 1),
    ],
    ids=["no memory", "a fault of the program"],
)
def test_a_tick_that_fails_is_left_out_and_many_end_the_run(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    step: str,
    fails: Any,
    error: type[Exception],
    text: str,
    told_in_full: int,
) -> None:
    desk, boat = holding(tmp_path)
    traces: list[str] = []
    boat.vessel.containment.report = traces.append if told_in_full else None
    for _ in range(2):
        with monkeypatch.context() as short:
            short.setattr(boat.vessel, step, fails)
            for _ in range(15):
                boat.step()
        desk.heartbeat()
        desk.tick(3)
        tick: Any = boat.vessel.last_tick
        assert tick.status.armed and tick.t_s > boat.now_s - 0.2
    assert any(re.fullmatch(text, said) for said in desk.texts())
    assert len(traces) == told_in_full
    monkeypatch.setattr(boat.vessel, step, fails)
    with pytest.raises(error):
        for _ in range(30):
            boat.step()
    monkeypatch.undo()
    desk.close()


def test_a_driver_that_fails_costs_its_device_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    desk, boat = holding(tmp_path)
    traces: list[str] = []
    boat.vessel.containment.report = traces.append
    with monkeypatch.context() as fault:
        fault.setattr(Mtdata2Sensor, "read", failing)
        for _ in range(15):
            boat.step()
        tick: Any = boat.vessel.last_tick
        faulty = [device for device in tick.health if not device.ok]
        assert [(device.name, device.text) for device in faulty] == [("imu", "driver fails (ZeroDivisionError)")]
        assert tick.status.armed
        heard: set[type] = set()
        for _ in range(10):
            boat.step()
            tick = boat.vessel.last_tick
            heard |= {type(reading) for reading in tick.readings}
        assert GnssFix in heard, "the others are read"
    for _ in range(4):
        desk.heartbeat()
        desk.tick(8)
    texts = desk.texts()
    assert "imu: driver fails (ZeroDivisionError)" in texts and "imu: back" in texts
    assert len(traces) == 1 and "ZeroDivisionError" in traces[0] and "in failing" in traces[0]
    desk.close()


def test_a_run_that_reports_nothing_raises_the_first_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    desk, boat = holding(tmp_path)
    with monkeypatch.context() as fault:
        fault.setattr(boat.vessel, "allocate", failing)
        with pytest.raises(ZeroDivisionError):
            boat.step()
        fault.setattr(Mtdata2Sensor, "read", failing)
        with pytest.raises(ZeroDivisionError):
            boat.step()
    desk.close()


@pytest.mark.process
@pytest.mark.sweep
def test_a_running_boat_without_descriptors_sails_says_so_and_recovers(tmp_path: Path) -> None:
    """With real-time priority where the system gives it. Nobody reads what it prints; a signal ends it in order."""
    companion = Companion(tmp_path, extra=("--realtime",)).start()
    process = companion.process
    assert process is not None and process.stdout is not None
    process.stdout.close()
    station = mavutil.mavlink_connection(f"tcp:127.0.0.1:{companion.tcp_port}", source_system=255)
    assert station.wait_heartbeat(timeout=CAP_S) is not None
    texts: list[str] = []

    def told(text: str) -> bool:
        station.mav.heartbeat_send(6, 8, 0, 0, 4)
        texts.extend(m.text for m in iter(lambda: station.recv_match(type="STATUSTEXT", blocking=False), None))
        return any(text in one for one in texts)

    wait_until(lambda: told("USV companion"), "the greeting")
    pid, asked = process.pid, [0.75]
    before = resource.prlimit(pid, resource.RLIMIT_NOFILE)

    def store_without_descriptors() -> None:
        """Anew while a file that was just open leaves one to store with."""
        in_use = len(os.listdir(f"/proc/{pid}/fd"))  # noqa: PTH208
        resource.prlimit(pid, resource.RLIMIT_NOFILE, (in_use, before[1]))
        asked.append(asked[-1] + 0.0625)
        station.mav.param_set_send(1, 1, b"WP_SPEED", asked[-1], 9)

    wait_until(lambda: told("Too many open files"), "the refusal to store", again=store_without_descriptors)
    with socket.create_connection(("127.0.0.1", companion.tcp_port)) as second:
        second.settimeout(CAP_S)
        assert second.recv(1) == b"", "turned away"
    wait_until(lambda: told("Computer: few file descriptors left"), "what is missing")
    sailed_s = companion.now_s
    resource.prlimit(pid, resource.RLIMIT_NOFILE, before)
    wait_until(lambda: told("is saved again") and told("Computer: well again"), "all is well")
    assert companion.now_s > sailed_s
    process.send_signal(signal.SIGPIPE)
    companion.sail(1.0)
    process.send_signal(signal.SIGTERM)
    wait_until(lambda: process.poll() is not None, "the end")
    assert process.returncode == 0
    assert str(asked[-1]) in (tmp_path / "state" / "parameters.json").read_text(encoding="utf-8")
    assert process.stdin is not None and process.stderr is not None
    process.stdin.close()
    process.stderr.close()
    station.close()
