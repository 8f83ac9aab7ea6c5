"""Where a boat will be that turns to a heading and takes a speed: the choices it has to get out of the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.config.reversing import can_reverse, turns_on_the_spot
from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.obstacles.nozzle_turn import NozzleTurn
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

STEP_S = 0.5
TIMES_S: Floats = np.arange(0.0, 20.0, STEP_S)
"""How far the boat's motion is predicted."""
_SWAY_S = 2.5  # in which sideways motion through the water decays
_TURN_S, _TURN_SHARE = 0.5, 0.75  # before a turn has begun, and of PATH_YAW_RATE in it
_LAG = 1.5  # times 1/PATH_BW_SURGE: delay of the boat's speed behind its demand
_HEADINGS_RAD = tuple(i * math.tau / 12.0 for i in range(12))


@dataclass(frozen=True, slots=True)
class Choices:
    """Headings and speeds over ground, and the way after which the boat stops; shape (n,) each."""

    yaw_rad: Floats
    surge_mps: Floats
    out_m: Floats

    def only(self, these: NDArray[np.bool_] | NDArray[np.int_]) -> Choices:
        """Some of them: indices, or True for each that is taken."""
        return Choices(self.yaw_rad[these], self.surge_mps[these], self.out_m[these])

    def turns_rad(self, from_rad: float) -> Floats:
        """The shorter turn from a heading to each, -π to π, shape (n,)."""
        turns: Floats = np.remainder(self.yaw_rad - from_rad + math.pi, math.tau) - math.pi
        return turns


class WaysOut:
    """`choices(…)`: what the boat can do; `places(choices, nav)`: where it then is. `coasts`: it has no thrust astern.
    Remembers nothing."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._signs = (1.0, -1.0) if can_reverse(config.thrusters) else (1.0,)
        self.coasts = not (can_reverse(config.thrusters) or config.has_sail)
        self._hull = config.hull
        self._on_the_spot = turns_on_the_spot(config.thrusters)
        jet = config.thrusters[0].kind == "jet"
        self._nozzle = NozzleTurn(config, parameters, STEP_S, len(TIMES_S)) if jet else None

    @property
    def by_nozzle(self) -> bool:
        """Whether a jet's nozzle turns the boat."""
        return self._nozzle is not None

    def choices(self, yaw_rad: float, speeds_mps: Sequence[float], out_m: float, turns: bool) -> Choices:
        """Ahead and astern at each of the speeds, on the heading `yaw_rad` and, where the boat `turns`, on twelve
        others. One that a nozzle turns can also coast."""
        headings = [yaw_rad, *_HEADINGS_RAD] if turns else [yaw_rad]
        surge = [sign * speed for speed in speeds_mps for sign in self._signs]
        yaw, speeds = np.repeat(headings, len(surge)), np.tile(surge, len(headings))
        if self._nozzle is not None:
            yaw, speeds = np.append(yaw, yaw_rad), np.append(speeds, 0.0)
        return Choices(yaw, speeds, np.full(len(yaw), out_m))

    def places(self, choices: Choices, nav: NavState) -> tuple[Floats, Floats]:
        """Where the boat will be, north and east at `TIMES_S`, shape (n, k): its speed goes to the one asked for, its
        heading too, sideways it goes on with the current. A jet's nozzle turns it by thrust, which drives it on."""
        if self._nozzle is not None:
            return _turned(self._nozzle, choices, nav)
        times = TIMES_S[None, :]
        asked, out = choices.surge_mps[:, None], choices.out_m[:, None]
        lag_s = _LAG / self._parameters["PATH_BW_SURGE"]
        speed = asked + (nav.surge_mps - asked) * np.exp(-times / lag_s)
        if self.coasts:  # only the water brakes it
            speed = np.maximum(speed, self._coasting_mps(nav))
        way = np.clip(_summed(0.5 * STEP_S * (speed[:, 1:] + speed[:, :-1])), -out, out)
        yaw = self._yaw_rad(choices, speed, nav)
        steps = np.diff(way)
        middle = 0.5 * (yaw[:, 1:] + yaw[:, :-1])
        side_n, side_e = _drift(nav, yaw)
        return (
            nav.north_m + _summed(steps * np.cos(middle)) + side_n,
            nav.east_m + _summed(steps * np.sin(middle)) + side_e,
        )

    def turning_s(self, yaw_rad: float, nav: NavState) -> float:
        """How long the boat turns on the spot to a heading; 0 for one that makes way meanwhile."""
        return _TURN_S + abs(wrap_pi(yaw_rad - nav.yaw_rad)) / self._fastest_radps if self._on_the_spot else 0.0

    @property
    def _fastest_radps(self) -> float:
        return _TURN_SHARE * math.radians(self._parameters["PATH_YAW_RATE"])

    def _coasting_mps(self, nav: NavState) -> Floats:
        """Speed over ground at `TIMES_S` of the hull without thrust, shape (1, k)."""
        stream_mps = 0.0
        if nav.current_north_mps is not None and nav.current_east_mps is not None:
            stream_mps = ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)[0]
        water_mps, speeds = nav.surge_mps - stream_mps, []
        for _ in TIMES_S:
            speeds.append(stream_mps + water_mps)
            slower = STEP_S * self._hull.drag_n(abs(water_mps)) / self._hull.m11_kg
            water_mps -= math.copysign(min(abs(water_mps), slower), water_mps)
        return np.asarray(speeds)[None, :]

    def _yaw_rad(self, choices: Choices, speed: Floats, nav: NavState) -> Floats:
        """Headings, shape (n, k). A rudder or a nozzle turns the boat by its way alone."""
        fastest = self._fastest_radps
        turn = choices.turns_rad(nav.yaw_rad)
        if self._on_the_spot:
            turned = np.broadcast_to(fastest * np.maximum(0.0, TIMES_S - _TURN_S), speed.shape)
        else:
            share = np.clip(speed / np.maximum(np.abs(choices.surge_mps[:, None]), 1e-3), 0.0, 1.0)
            turned = fastest * _summed(STEP_S * share[:, 1:])
        yaw: Floats = nav.yaw_rad + np.sign(turn)[:, None] * np.minimum(np.abs(turn)[:, None], turned)
        return yaw


def _turned(nozzle: NozzleTurn, choices: Choices, nav: NavState) -> tuple[Floats, Floats]:
    """`places` of a boat that its nozzle turns: after its way it coasts."""
    found = nozzle.predicted(choices.yaw_rad, choices.surge_mps, nav, choices.out_m)
    north, east = found.north_mps, found.east_mps
    return (
        nav.north_m + _summed(0.5 * STEP_S * (north[:, 1:] + north[:, :-1])),
        nav.east_m + _summed(0.5 * STEP_S * (east[:, 1:] + east[:, :-1])),
    )


def _summed(steps: Floats) -> Floats:
    """From 0 on, shape (n, k) of (n, k − 1) steps."""
    return np.concatenate((np.zeros((len(steps), 1)), np.cumsum(steps, axis=1)), axis=1)


def _drift(nav: NavState, yaw: Floats) -> tuple[Floats, Floats]:
    """Way that is not along the heading, north and east: across it the current takes the boat, and its own motion
    through the water goes on for a while. Without a known current, all of the present motion goes on."""
    if nav.current_north_mps is None or nav.current_east_mps is None:
        rest_mps, stream_n, stream_e = nav.sway_mps, 0.0, 0.0
        decayed = TIMES_S
    else:
        stream_n, stream_e = nav.current_north_mps, nav.current_east_mps
        rest_mps = nav.sway_mps - ned_to_body(stream_n, stream_e, nav.yaw_rad)[1]
        decayed = _SWAY_S * (1.0 - np.exp(-TIMES_S / _SWAY_S))
    across = stream_e * np.cos(yaw) - stream_n * np.sin(yaw)
    north, east = -across * np.sin(yaw), across * np.cos(yaw)
    return (
        _summed(0.5 * STEP_S * (north[:, 1:] + north[:, :-1])) - rest_mps * math.sin(nav.yaw_rad) * decayed,
        _summed(0.5 * STEP_S * (east[:, 1:] + east[:, :-1])) + rest_mps * math.cos(nav.yaw_rad) * decayed,
    )
