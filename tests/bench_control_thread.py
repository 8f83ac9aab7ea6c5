"""The part of `make bench` that says how long requests keep the control thread: the most processor time that it spends
at a time, in one tick or in one answer between two, with the largest plans. What takes longer is done beside it.

Each request is made several times, and the row has the least of the longest: other processes only add to it. Beside it
stands what a tick costs in the middle, at the same time and on the same machine.
"""

from __future__ import annotations

import gc
import statistics
from collections.abc import Callable
from pathlib import Path
from typing import Any

from companion.io.mavlink.wire import messages
from tests.afloat_beside import BoatBeside
from tests.bench_console import Line
from tests.bench_stopwatches import TimedVessel, time_world
from tests.protocol.desk import Desk
from tests.waiting import wait_until

COUNT = 10_000
_TIMES = 3
_WAYPOINT, _RETURN, _KEEP_OUT = 16, 20, 5004
_ORBIT, _GO_TO, _SET_HOME = 34, 192, 179
_HOLD, _MISSION, _RTL = 3.0, 4.0, 5.0  # sub-modes of AUTO
_NAN = float("nan")


class _Longest:
    """The processor time that the control thread spends at a time, without the plant: in one tick, or in one answer
    between two."""

    def __init__(self, boat: BoatBeside) -> None:
        self._took_s: dict[str, list[float]] = {"tick": [], "serve": []}
        boat.vessel = TimedVessel(boat.vessel, time_world(boat.vessel), self._took)  # type: ignore[assignment]

    def _took(self, what: str, took_s: float) -> None:
        self._took_s[what].append(took_s)

    def take_ms(self) -> tuple[float, float]:
        """(the longest, the median of the ticks), from now on anew."""
        ticks_s, serves_s = self._took_s.values()
        longest_s = max((*ticks_s, *serves_s), default=0.0)
        median_s = statistics.median(ticks_s) if ticks_s else 0.0
        ticks_s.clear()
        serves_s.clear()
        return 1e3 * longest_s, 1e3 * median_s


class _Bench:
    """One boat whose writers and worker run beside, its ground station, and the rows."""

    def __init__(self, folder: Path, vessel: str, line: Line) -> None:
        self.boat = BoatBeside(folder / vessel, vessel=vessel)
        self.desk = Desk(folder, self.boat)  # type: ignore[arg-type]
        self._line = line
        home = self.boat.vessel.config.home
        self.lat, self.lon = round(home.lat_deg * 1e7), round(home.lon_deg * 1e7)
        self.desk.ready()
        self.tick(100)
        self._longest = _Longest(self.boat)

    def tick(self, count: int) -> None:
        """Ticks of a boat whose ground station stays."""
        for n in range(count):
            if n % 20 == 0:
                self.desk.heartbeat()
            self.desk.tick()
            self.desk.received.clear()

    def row(self, what: str, *steps: Callable[[], object]) -> None:
        """Print the least of what the last step costs, each time after the others."""
        times_ms = []
        for _ in range(_TIMES):
            for step in steps[:-1]:
                step()
            self._longest.take_ms()
            steps[-1]()
            times_ms.append(self._longest.take_ms())
        longest_ms, tick_ms = min(times_ms)
        self._line(f"  {what}", f"{longest_ms:.1f} ms, a tick {tick_ms:.1f} ms", "under 10 ms")

    def mode(self, sub_mode: float, ticks: int = 30) -> None:
        """Choose a mode."""
        self.desk.command(messages.MAV_CMD_DO_SET_MODE, 1.0, 4.0, sub_mode)
        self.tick(ticks)

    def order(self, command: int, *params: float, north: int = 0, east: int = 0, ticks: int = 30) -> None:
        """A command with a place, in 1e-7 degrees from home."""
        x, y = self.lat + north, self.lon + east
        self.desk.tell(messages.MAVLink_command_int_message(1, 1, 6, command, 0, 0, *params, x, y, 0.0))
        self.tick(ticks)

    def current(self, seq: int, ticks: int = 30) -> None:
        """Make that item the current one."""
        self.desk.command(messages.MAV_CMD_DO_SET_MISSION_CURRENT, float(seq))
        self.tick(ticks)

    def upload(self, items: list[Any], kind: int = 0, ticks: int = 30) -> None:
        """As a client does it, and until it is acknowledged."""
        desk = self.desk
        gc.collect()
        gc.freeze()  # what the client has is no part of the boat
        answers = desk.tell(messages.MAVLink_mission_count_message(1, 1, len(items), kind))
        while requests := [answer.seq for answer in answers if answer.get_type() == "MISSION_REQUEST_INT"]:
            answers = desk.tell(items[requests[-1]])
            desk.received.clear()
        wait_until(lambda: any(m.get_type() == "MISSION_ACK" for m in (*answers, *desk.tell())), "MISSION_ACK")
        self.tick(ticks)

    def clear(self) -> None:
        """All plans."""
        self.desk.tell(messages.MAVLink_mission_clear_all_message(1, 1, 255))
        self.tick(20)

    def list_plans(self) -> None:
        """ListDirectory of `plans`, and until it is answered."""
        path = b"plans"
        payload = bytes((1, 0, 0, 3, len(path), 0, 0, 0, 0, 0, 0, 0)) + path
        message = messages.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload.ljust(251, b"\0")))
        answers = self.desk.tell(message)
        wait_until(lambda: any(m.get_type() == "FILE_TRANSFER_PROTOCOL" for m in (*answers, *self.desk.tell())), "list")

    def mission(self, count: int = COUNT, first: int = _WAYPOINT) -> list[Any]:
        """Waypoints: the first 45 half a metre apart, then lanes of legs of 20 m."""
        items = []
        for seq in range(count):
            row, place = divmod(seq, 100)
            north, east = (100 + 45 * seq, 20 * (seq % 2)) if seq < 45 else (2500 + 1800 * row, 4000 * place)
            items.append(self._item(seq, first if seq == 0 else _WAYPOINT, north, east))
        return items

    def zones(self, count: int, north: int, every: int) -> list[Any]:
        """Circles of a metre to keep out of, from `north` on."""
        return [
            messages.MAVLink_mission_item_int_message(
                1, 1, seq, 0, _KEEP_OUT, 0, 1, 1.0, 0.0, 0.0, 0.0,
                self.lat + north + every * (seq // 100), self.lon - 20_000 + 2 * every * (seq % 100), 0.0, 1,
            )
            for seq in range(count)
        ]  # fmt: skip

    def _item(self, seq: int, command: int, north: int, east: int) -> Any:
        return messages.MAVLink_mission_item_int_message(
            1, 1, seq, 6, command, 0, 1, 0.0, 0.0, 0.0, _NAN, self.lat + north, self.lon + east, 0.0
        )

    def under_way(self) -> bool:
        """Whether the active mode sails along a way, a tick later."""
        self.tick(1)
        return self.boat.vessel.supervisor.parts.helm.mode.goes_round

    def home_behind(self) -> None:
        """RTL to a home beyond the zones, until its way is found."""
        self.mode(_RTL, ticks=1)
        wait_until(self.under_way, "the way home")

    def sail_to(self, seq: int) -> None:
        """Sail until that item is the current one, at ten times real time at most: the way is laid in a thread beside,
        and a boat that waits for it for 40 s of its own time is stuck."""

        def there() -> bool:
            self.tick(1)
            return self.boat.vessel.executor.progress.seq >= seq

        wait_until(there, f"item {seq}")


def most_at_a_time(folder: Path, line: Line) -> None:
    """The rows of a boat that follows its path by feedback, and of one that plans its motion along it."""
    for vessel in ("revolt", "aboat"):
        bench = _Bench(folder / "most_at_a_time", vessel, line)
        line(f"most at a time: {vessel}", "", "")
        _plans(bench)
        _under_way(bench)
        bench.boat.close()
        gc.unfreeze()


def _plans(bench: _Bench) -> None:
    mission, zones = bench.mission(), bench.zones(COUNT, 40_000, 400)
    bench.row("nothing asked", lambda: bench.tick(60))
    bench.row(f"upload of {COUNT} items", lambda: bench.upload(mission))
    bench.row(f"upload of {COUNT} fence zones, check of the mission", lambda: bench.upload(zones, 1, ticks=100))
    bench.row("listing plans over FTP", bench.list_plans)


def _under_way(bench: _Bench) -> None:
    near = bench.zones(1000, 300, 60)
    short = bench.mission(4, _RETURN)

    def hold() -> None:
        bench.mode(_HOLD)

    def sail() -> None:
        bench.mode(_MISSION, ticks=60)

    bench.desk.command(messages.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
    bench.tick(30)
    bench.row("mission entry", hold, sail)
    bench.row("  the next 40 items", lambda: bench.current(0, 1), lambda: bench.sail_to(42))
    bench.row("  set current item 9,999", sail, lambda: bench.current(COUNT - 1))
    bench.current(10)
    bench.row("  1,000 zones in its way", lambda: bench.upload(near[:1], 1), lambda: bench.upload(near, 1, ticks=60))
    bench.row("RTL", hold, lambda: bench.mode(_RTL))
    bench.row("go-to", hold, lambda: bench.order(_GO_TO, -1.0, 1.0, 0.0, _NAN, north=-3000, east=-2000))
    bench.row("go-to, refused", hold, lambda: bench.order(_GO_TO, -1.0, 1.0, 0.0, _NAN, north=9000))
    bench.row("orbit", hold, lambda: bench.order(_ORBIT, 20.0, _NAN, 0.0, _NAN, north=-3000, east=-2000))
    bench.row("orbit, refused", hold, lambda: bench.order(_ORBIT, 60.0, _NAN, 0.0, _NAN, north=2000))
    hold()
    bench.order(_SET_HOME, 0.0, 0.0, 0.0, 0.0, north=9000)
    bench.row("RTL to a home behind the zones", hold, bench.home_behind)
    hold()
    bench.upload(short)
    bench.row("return item, behind the zones", hold, lambda: bench.current(0), sail)
    hold()
    bench.row("clearing all plans", lambda: bench.upload(bench.mission()), bench.clear)
