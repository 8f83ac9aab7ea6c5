"""Tells ground stations how a calibration goes, in the way that each persona's clients draw.

PX4's: texts that begin with `[cal]`, as QGroundControl's Sensors page and MAVSDK read them (their version 2).
ArduPilot's: MAG_CAL_PROGRESS and MAG_CAL_REPORT, for the compass.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from companion.core.decision import TextKind
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import pack
from companion.io.mavlink.wire.hub import Handler, Hub
from companion.loop import Vessel
from companion.supervisor.calibration import CalibrationKind, CalibrationPhase, CalibrationState, CompassState

_WORDS = {CalibrationKind.COMPASS: "mag", CalibrationKind.LEVEL: "level", CalibrationKind.GYRO: "gyro"}
_PERIOD_S = 0.5
_STATUS = {  # MAG_CAL_STATUS
    CalibrationPhase.RUNNING: 2,
    CalibrationPhase.FITTED: 4,
    CalibrationPhase.DONE: 4,
    CalibrationPhase.FAILED: 5,
    CalibrationPhase.CANCELLED: 0,
}
_MASK_BYTES = 10


class CalibrationService:
    """Remembers what was told last, and when."""

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._calibration = vessel.supervisor.calibration
        self._run = 0
        self._phase: CalibrationPhase | None = None
        self._percent = -1
        self._told_s = -math.inf
        self.handles: Mapping[int, Handler] = {}

    def update(self, now_s: float) -> None:
        """Tell what has changed."""
        state = self._calibration.state
        if state is None or (
            state.phase is not CalibrationPhase.RUNNING and (state.run, state.phase) == (self._run, self._phase)
        ):
            return
        if state.run != self._run:
            self._run, self._phase, self._percent = state.run, CalibrationPhase.RUNNING, -1
            self._say(_begun(state.kind))
        if state.phase is CalibrationPhase.RUNNING:
            self._progress(state, now_s)
        elif state.phase is not CalibrationPhase.DONE or not self._hub.vessel.storage.parameters().pending:
            self._phase = state.phase
            self._end(state)

    def _end(self, state: CalibrationState) -> None:
        """Tell how it ended. It is done when its result is stored; the storage tells why it is not."""
        if state.phase is CalibrationPhase.DONE and not self._hub.vessel.storage.parameters().durable:
            state = replace(state, phase=CalibrationPhase.FAILED, text="not stored")
        self._say(_ended(state))
        self._report(state)

    def _progress(self, state: CalibrationState, now_s: float) -> None:
        percent = int(100.0 * state.progress)
        if percent == self._percent or now_s - self._told_s < _PERIOD_S:
            return
        self._percent, self._told_s = percent, now_s
        self._say((f"[cal] progress <{percent}>",))
        self._send([_mag_cal_progress(compass, state) for compass in state.compasses])

    def _report(self, state: CalibrationState) -> None:
        self._send(
            [
                _mag_cal_report(compass, state)
                for compass in state.compasses
                if state.phase is not CalibrationPhase.CANCELLED
            ]
        )

    def _say(self, lines: Sequence[str]) -> None:
        for line in lines:
            for message in self._hub.texts(TextKind.ROUTINE, line):
                packed = pack(message)
                for outlet in self._hub.listeners:
                    if not outlet.persona.calibrates_by_messages:
                        self._hub.send_packed(outlet, packed)

    def _send(self, messages: Sequence[Any]) -> None:
        for packed in map(pack, messages):
            for outlet in self._hub.listeners:
                if outlet.persona.calibrates_by_messages:
                    self._hub.send_packed(outlet, packed)


def _begun(kind: CalibrationKind) -> Sequence[str]:
    started = f"[cal] calibration started: 2 {_WORDS[kind]}"
    return (started, "[cal] down orientation detected") if kind is CalibrationKind.COMPASS else (started,)


def _ended(state: CalibrationState) -> Sequence[str]:
    match state.phase:
        case CalibrationPhase.FAILED:
            return (f"[cal] calibration failed: {state.text}",)
        case CalibrationPhase.CANCELLED:
            return ("[cal] calibration cancelled",)
        case CalibrationPhase.DONE:
            side = (
                ("[cal] down side done, rotate to a different side",) if state.kind is CalibrationKind.COMPASS else ()
            )
            return ("[cal] progress <100>", *side, f"[cal] calibration done: {_WORDS[state.kind]}")
    return ()


def _mask(compasses: Sequence[CompassState]) -> int:
    return sum(1 << compass.number for compass in compasses)


def _mag_cal_progress(compass: CompassState, state: CalibrationState) -> Any:
    done = round(8 * _MASK_BYTES * compass.progress)  # sections of the sphere there; here a share of the turns
    seen = ((1 << done) - 1).to_bytes(_MASK_BYTES, "little")
    percent, mask = int(100.0 * compass.progress), _mask(state.compasses)
    return mavlink.MAVLink_mag_cal_progress_message(
        compass.number, mask, _STATUS[state.phase], 1, percent, list(seen), *compass.direction
    )


def _mag_cal_report(compass: CompassState, state: CalibrationState) -> Any:
    """Offsets in the magnetometer's unit; fitness as the RMS error of the strength, in thousandths of the field."""
    fit = compass.fit
    offset = (0.0, 0.0, 0.0) if fit is None else fit.offset.tolist()
    (a, b, c), (_, d, e), (_, _, f) = ((0.0,) * 3,) * 3 if fit is None else fit.matrix.tolist()
    fitness = 0.0 if fit is None else 1e3 * fit.residual
    saved = int(state.phase is CalibrationPhase.DONE)
    return mavlink.MAVLink_mag_cal_report_message(
        compass.number, _mask(state.compasses), _STATUS[state.phase], saved, fitness, *offset, a, d, f, b, c, e
    )
