"""A day at sea with a hostile client in lockstep: what the boat keeps does not grow.

The client speaks in every tick, as many systems: whole messages of every kind, broken ones, noise, uploads that it does
not finish, files and logs that it does not read. SOAK_H sets another length, in hours of the boat's time.
"""

from __future__ import annotations

import ctypes
import gc
import os
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Packed, frame, pack
from tests.afloat import BoatAfloat
from tests.protocol.test_client_lives import counts, ftp, item

HOURS = float(os.environ.get("SOAK_H", "24"))
WARM_H = 0.1
_IDS = sorted(mavlink.MESSAGES)


class Hostile:
    """`bytes_now()`: what it sends in one tick."""

    def __init__(self, seed: int) -> None:
        self._draws = random.Random(seed)
        self._sequence = 0
        self._kinds: Sequence[Callable[[], Any]] = (
            lambda: mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3),
            lambda: mavlink.MAVLink_param_request_list_message(1, 1),
            lambda: mavlink.MAVLink_param_set_message(1, 1, self._name(), self._draws.uniform(-1e3, 1e3), 9),
            lambda: mavlink.MAVLink_mission_count_message(1, 1, self._draws.randrange(2000), self._draws.randrange(4)),
            lambda: item(self._draws.randrange(20)),
            lambda: mavlink.MAVLink_mission_request_list_message(1, 1, self._draws.randrange(4)),
            lambda: mavlink.MAVLink_mission_request_int_message(1, 1, self._draws.randrange(20), 0),
            lambda: ftp(self._draws.randrange(20), self._draws.choice((b"/", b"general.json", b"@PARAM/param.pck"))),
            lambda: mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF),
            lambda: mavlink.MAVLink_command_long_message(1, 1, self._command(), 0, *self._params()),
            lambda: mavlink.MAVLink_set_mode_message(1, 1, self._draws.randrange(10) << 16),
            lambda: mavlink.MAVLink_manual_control_message(1, *(self._draws.randrange(-999, 999) for _ in range(4)), 0),
            lambda: mavlink.MAVLink_serial_control_message(10, 6, 0, 0, 5, list(b"help\n".ljust(70, b"\0"))),
            lambda: mavlink.MAVLink_statustext_message(3, self._draws.randbytes(20)),
            lambda: mavlink.MAVLink_ping_message(self._draws.randrange(2**40), 1, 0, 0),
        )

    def bytes_now(self) -> bytes:
        """A few messages, or noise."""
        out = b""
        for _ in range(self._draws.randrange(4)):
            self._sequence = self._sequence + 1 & 0xFF
            out += self._one()
        return out

    def _one(self) -> bytes:
        chance, system = self._draws.random(), self._draws.randrange(2, 255)
        if chance < 0.1:
            return self._draws.randbytes(self._draws.randrange(1, 80))
        if chance < 0.4:
            number = self._draws.choice(_IDS)
            extra, size = bytes([mavlink.MESSAGES[number].crc_extra]), mavlink.MESSAGES[number].unpacker.size
            payload = self._draws.randbytes(size).rstrip(b"\0") or b"\0"
            whole = frame(Packed(number, extra, payload), self._sequence, system, 190)
        else:
            whole = frame(pack(self._draws.choice(self._kinds)()), self._sequence, system, self._draws.randrange(256))
        return whole[: self._draws.randrange(len(whole))] if chance > 0.97 else whole

    def _name(self) -> bytes:
        return self._draws.choice((b"WP_SPEED", b"NAV_ACC_RAD", b"NO_SUCH", self._draws.randbytes(16)))

    def _command(self) -> int:
        return self._draws.choice((400, 176, 192, 511, 512, 20, 21, 34, 183, 209, self._draws.randrange(65536)))

    def _params(self) -> list[float]:
        return [self._draws.choice((0.0, 1.0, self._draws.uniform(-100, 100))) for _ in range(7)]


def rss_kb() -> int:
    """Memory in use now, after what is free was given back."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def sailed(run: BoatAfloat, hostile: Hostile, hours: float) -> None:
    for _ in range(round(hours * 3600.0 / run.vessel.period_s)):
        run.send(hostile.bytes_now())
        run.step()
        run.receive()


class Faults:
    """A `Recorder` of what handlers and services failed at."""

    def __init__(self) -> None:
        self.texts: set[str] = set()

    def record(self, tick: Any) -> None:
        failed = ("mavlink_handler_failed", "mavlink_service_failed", "telemetry_failed")
        self.texts |= {event.text for event in tick.events if event.name in failed}

    def close(self) -> None: ...


def begun(folder: Path) -> tuple[BoatAfloat, Faults]:
    run, faults = BoatAfloat(folder / "state"), Faults()
    run.vessel.add_recorder(faults)
    return run, faults


def test_a_hostile_while_is_borne(tmp_path: Path) -> None:
    (run, faults), hostile = begun(tmp_path), Hostile(3)
    sailed(run, hostile, 8.0 / 3600.0)
    before = counts()
    sailed(run, hostile, 6.0 / 3600.0)
    after = counts()
    assert after["descriptors"] == before["descriptors"] and after["threads"] == before["threads"]
    assert not faults.texts
    run.close()


@pytest.mark.sweep
def test_a_hostile_day_leaves_nothing_behind(tmp_path: Path) -> None:
    (run, faults), hostile = begun(tmp_path), Hostile(7)
    sailed(run, hostile, WARM_H)
    first, begun_kb = counts(), rss_kb()
    print(f"after {WARM_H:g} h: {begun_kb} kB, {first}", flush=True)
    for number in range(24):
        sailed(run, hostile, (HOURS - WARM_H) / 24)
        now = WARM_H + (number + 1) * (HOURS - WARM_H) / 24
        print(f"after {now:.2f} h: {rss_kb() - begun_kb:+d} kB, {counts()}", flush=True)
    growth_kb, last = rss_kb() - begun_kb, counts()
    run.close()
    assert growth_kb < 2000
    assert not faults.texts
    assert last["descriptors"] <= first["descriptors"] and last["threads"] <= first["threads"]
