"""What somebody does, where a fault is none of the simulated devices: people, links, lead boats, the host."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.fault_matrix.stages import Stage
from sitl.fault_matrix.table import FaultRow
from sitl.scenarios.ground_station import Item
from sitl.traffic import ScriptedVessel

_CENTRED_US = (1500, 1500, 1500, 1500, 1000, 1000, 1000, 1000)
_SAFE_US = (1500, 1500, 1500, 1500, 2000, 1000, 1000, 1000)
_SWITCHED_S = 2.0  # from the safe switch to the silence of its transmitter
_STOPPED_S = 3.0
_LATE_S, _LATE_TIMES = 0.6, 10
_UNREPORTED = ("_runaway", "_stalled", "_reversed")
_DIFFERS, _DIFFERS_S = 0.25, 1.0  # of full throttle
_CLOCK_S = 3600.0
_FENCE_LENGTHS, _FENCE_M = 2.0, 3000.0  # to its east side, in lengths of the boat; to its other sides
_STREAM_MPS = 2.0
_GHOST_MMSI = 970_000_001
_GHOST_M, _GHOST_MPS = 150.0, 12.0


def begin(fault: FaultRow, stage: Stage) -> None:
    """Begin a fault now."""
    for name in fault.sitl:
        row = stage.row
        stage.rig.world.add_fault(name.format(thruster=row.thruster, bridge=row.bridge), fault.over_s or math.inf)
    if fault.deed:
        DEEDS[fault.deed](stage)
    if any(name.endswith(_UNREPORTED) for name in fault.sitl):
        _known_where_it_differs(stage)


def _known_where_it_differs(stage: Stage) -> None:
    """A propeller that happens to give what is commanded, or does so again soon, cannot be told."""
    names = [thruster.name for thruster in stage.rig.config.thrusters]
    thruster = stage.rig.world.thrusters[names.index(stage.row.thruster)]
    differs_s = 0.0

    def lasts() -> bool:
        nonlocal differs_s
        differs = abs(thruster.throttle() - thruster.asked) > _DIFFERS
        differs_s = differs_s + 1.0 / stage.rig.config.control_rate_hz if differs else 0.0
        return differs_s >= _DIFFERS_S

    stage.knowable = lasts


def _station_silent(stage: Stage) -> None:
    stage.gcs.heartbeats = False


def _link_cut(stage: Stage) -> None:
    """Nothing of the ground station arrives; what the boat sends is still read, to judge it."""
    stage.gcs.heartbeats = False
    stage.gcs.streamed = tuple


def _stream_silent(stage: Stage) -> None:
    stage.gcs.streamed = tuple


def _safe_switch(stage: Stage) -> None:
    stage.rig.world.set_transmitter(_SAFE_US)


def _safe_switch_silent(stage: Stage) -> None:
    stage.rig.world.set_transmitter(_SAFE_US)
    stage.later(_SWITCHED_S, lambda: stage.rig.world.add_fault("rc_lost"))


def _fence_crossed(stage: Stage) -> None:
    """A fence around the boat comes into force, and then a stream carries the boat out of it."""
    home, world = stage.rig.config.home, stage.rig.world
    frame, length_m = LocalFrame(home.lat_deg, home.lon_deg), stage.rig.config.length_m
    edge_m = world.truth.east_m + _FENCE_LENGTHS * length_m
    corners = ((-_FENCE_M, -_FENCE_M), (_FENCE_M, -_FENCE_M), (_FENCE_M, edge_m), (-_FENCE_M, edge_m))
    vertex = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
    items = [Item(vertex, *frame.to_geodetic(*corner), params=(4.0, 0.0, 0.0, 0.0)) for corner in corners]
    stage.gcs.upload(items, mavlink.MAV_MISSION_TYPE_FENCE)
    world.hull.set_current(0.0, _STREAM_MPS)
    stage.knowable = lambda: world.hull.east_m > edge_m


def _stopped(stage: Stage) -> None:
    stage.rig.pause(_STOPPED_S)


def _late(stage: Stage) -> None:
    for number in range(_LATE_TIMES):
        stage.later(number * 1.0, lambda: stage.rig.pause(_LATE_S))


def _clock_step(stage: Stage) -> None:
    stage.rig.set_clock_ahead(_CLOCK_S)


def _leader_silent(stage: Stage) -> None:
    if stage.convoy is not None:
        stage.convoy.paths[0].cuts.append((stage.rig.now_s, math.inf))


def _leader_has(fault: str) -> Callable[[Stage], None]:
    def begin_it(stage: Stage) -> None:
        if stage.convoy is not None:
            stage.convoy.boat.faults.add(fault)

    return begin_it


def _ghost(stage: Stage) -> None:
    """A vessel that is not there: by its AIS it comes at the boat and goes through it."""
    truth, now_s = stage.rig.world.truth, stage.rig.now_s
    passes_s = now_s + _GHOST_M / _GHOST_MPS
    points = (
        (now_s, truth.north_m + _GHOST_M, truth.east_m),
        (passes_s, truth.north_m, truth.east_m),
    )
    vessel = ScriptedVessel(_GHOST_MMSI, "GHOST", points, report_s=1.0)
    stage.rig.world.traffic.vessels.append(vessel)


DEEDS: Mapping[str, Callable[[Stage], None]] = {
    "station_silent": _station_silent,
    "link_cut": _link_cut,
    "stream_silent": _stream_silent,
    "safe_switch": _safe_switch,
    "safe_switch_silent": _safe_switch_silent,
    "fence_crossed": _fence_crossed,
    "stopped": _stopped,
    "late": _late,
    "clock_step": _clock_step,
    "leader_silent": _leader_silent,
    "leader_lost": _leader_has("gnss_lost"),
    "leader_frozen": _leader_has("gnss_frozen"),
    "leader_lying": _leader_has("gnss_off_100m"),
    "ghost": _ghost,
}
"""By its name in `expected.toml`."""
