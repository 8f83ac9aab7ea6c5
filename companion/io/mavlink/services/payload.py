"""Cameras and gimbals: commands that take pictures, and those that are passed on to a component on the links.

A component belongs to the boat if it has the boat's system id. Commands that are sent to it directly go by the router;
here are those that are sent to the boat, and those of missions. Source: MAVLink guide, "Camera Protocol v2", "Gimbal
Protocol v2".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from companion.core.decision import Outcome, TextKind
from companion.core.payload import Forward, PayloadPart, Shot
from companion.core.tick import Tick
from companion.io.mavlink.commands.request import (
    DONE,
    LATER,
    UNSUPPORTED,
    Answer,
    CommandHandler,
    CommandRequest,
    denied,
    not_now,
)
from companion.io.mavlink.telemetry.following import streamed
from companion.io.mavlink.telemetry.payload import camera_feedback, camera_trigger
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import pack
from companion.io.mavlink.wire.hub import COMPONENT, Handler, Hub, Peer
from companion.loop import Vessel
from companion.mission.commands import RULES, name_of
from companion.mission.payload import PASSED_ON, payload_action
from companion.mission.plan import item_number

ANSWER_S = 1.0  # QGroundControl waits 3 s for an acknowledgement
AGAIN_S = 0.4
_WORKING_S = 5.0  # for a component that says it is at it
_SILENT_S = 5.0  # heartbeats come every second
_BY_NUMBER = {  # for components whose heartbeat does not say what they are
    **dict.fromkeys(range(100, 106), PayloadPart.CAMERA),
    **dict.fromkeys((154, *range(171, 176)), PayloadPart.GIMBAL),
}
_KINDS = {mavlink.MAV_TYPE_CAMERA: PayloadPart.CAMERA, mavlink.MAV_TYPE_GIMBAL: PayloadPart.GIMBAL}
_ACCEPTED, _IN_PROGRESS, _FAILED = (
    mavlink.MAV_RESULT_ACCEPTED,
    mavlink.MAV_RESULT_IN_PROGRESS,
    mavlink.MAV_RESULT_FAILED,
)


@dataclass(slots=True)
class _Component:
    """A camera or gimbal, where it was heard last. `reports`: it tells of its pictures itself."""

    part: PayloadPart
    peer: Peer
    heard_s: float
    reports: bool = False


@dataclass(slots=True)
class _Pending:
    """A command that was passed on. `request`: who asked; None for a mission."""

    action: Forward
    request: CommandRequest | None
    due_s: float
    again_s: float | None


class PayloadService:
    """In: commands by way of `CommandService`; HEARTBEAT, COMMAND_ACK and CAMERA_IMAGE_CAPTURED of components; pictures
    and commands of missions from the tick. Out: the commands to the components, their answers to who asked,
    CAMERA_TRIGGER and CAMERA_FEEDBACK to all.

    Remembers the components heard, and the commands that wait for an answer.
    """

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._components: dict[int, _Component] = {}
        self._pending: dict[tuple[int, int], _Pending] = {}  # by component and command
        self.commands: Mapping[int, CommandHandler] = {
            **dict.fromkeys(map(int, PASSED_ON), self.pass_on),
            mavlink.MAV_CMD_DO_DIGICAM_CONTROL: self.digicam,
            mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST: self.by_distance,
            mavlink.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL: self.by_interval,
            mavlink.MAV_CMD_IMAGE_START_CAPTURE: self.start_capture,
            mavlink.MAV_CMD_IMAGE_STOP_CAPTURE: self.stop_capture,
            mavlink.MAV_CMD_DO_TRIGGER_CONTROL: self.trigger_control,
        }
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_HEARTBEAT: self._on_heartbeat,
            mavlink.MAVLINK_MSG_ID_COMMAND_ACK: self._on_ack,
            mavlink.MAVLINK_MSG_ID_CAMERA_IMAGE_CAPTURED: self._on_captured,
        }

    def update(self, now_s: float) -> None:
        """Pictures and commands of the tick; what is not answered; who is silent."""
        self._forget(now_s)
        tick = self._vessel.last_tick
        if tick is not None:
            for shot in tick.shots:
                self._tell_of(shot, tick)
            for action in tick.forwards:
                self._pass_on(action, None, now_s)
        for key, pending in list(self._pending.items()):
            if now_s >= pending.due_s:
                del self._pending[key]
                self._finish(pending, _FAILED, f"{pending.action.part.value} {key[0]} does not answer", now_s)
            elif pending.again_s is not None and now_s >= pending.again_s:
                pending.again_s = None
                self._send(key[0], pending.action, 1)

    # --- commands --------------------------------------------------------------------------------------------------

    def pass_on(self, request: CommandRequest) -> Outcome | Answer:
        """Passed on to a camera or gimbal with the boat's system id: the one that the command names by its component,
        else the first that is heard. Its answer is the answer."""
        return self._carry_out(request)

    def digicam(self, request: CommandRequest) -> Outcome | Answer:
        """A picture now, on every camera of the vessel file. Zoom and focus are passed on.

        param5: 1 takes a picture.
        """
        return self._carry_out(request)

    def by_distance(self, request: CommandRequest) -> Outcome | Answer:
        """Pictures by distance along the track.

        param1: Metres between two pictures; 0 stops.
        param2: Ignored.
        param3: 1: a picture at once, also when it stops.
        param4: Number of the camera from 1; 0: all.
        """
        return self._carry_out(request)

    def by_interval(self, request: CommandRequest) -> Outcome | Answer:
        """Pictures by time, the first at once, until they are stopped.

        param1: Milliseconds between two pictures; 0 and −1 change nothing.
        param2: Ignored.
        param3: Number of the camera from 1; 0: all.
        """
        return self._carry_out(request)

    def start_capture(self, request: CommandRequest) -> Outcome | Answer:
        """One picture, or pictures by time.

        param1: Number of the camera from 1; 0: all.
        param2: Seconds between two pictures, at the camera's own pace where that is longer.
        param3: How many; 0: until they are stopped.
        param4: For one picture: number of the request. The same number within 5 s is a repetition.
        """
        return self._carry_out(request)

    def stop_capture(self, request: CommandRequest) -> Outcome | Answer:
        """No more pictures by distance or time.

        param1: Number of the camera from 1; 0: all.
        """
        return self._carry_out(request)

    def trigger_control(self, request: CommandRequest) -> Outcome | Answer:
        """Switch the pictures by distance or time off and on, as they are.

        param1: 1 on, 0 off; −1: no change.
        param2: 1 numbers the pictures from 1 again.
        param3: 1 pauses, 0 goes on; −1: no change.
        """
        return self._carry_out(request)

    def _carry_out(self, request: CommandRequest) -> Outcome | Answer:
        """Check the parameters, then take the picture or pass the command on."""
        for allowed in RULES[request.command].ranges:
            value = request.params[allowed.number - 1]
            if not allowed.allows(value):
                return denied(f"{allowed.label} of {name_of(request.command)} is {value:g}; {allowed.remedy}")
        action = payload_action(request.command, request.params, request.frame)
        if action is None:
            return UNSUPPORTED
        if isinstance(action, Forward):
            return self._passed_on(action, request)
        return Answer(self._vessel.supervisor.payload.request(action, request.now_s))

    # --- passing on ------------------------------------------------------------------------------------------------

    def _passed_on(self, action: Forward, request: CommandRequest) -> Answer:
        reason = self._vessel.supervisor.payload.lacking(action)
        if reason is not None:
            return not_now(reason) if reason else DONE
        return (
            LATER
            if self._pass_on(action, request, request.now_s)
            else not_now("another client's request is still under way")
        )

    def _pass_on(self, action: Forward, request: CommandRequest | None, now_s: float) -> bool:
        """Send a command to its component. False where the same command of somebody else waits for its answer; of one's
        own, with other params, the newest counts."""
        number = self._vessel.supervisor.payload.component(action.part, action.component)
        if number is None or number not in self._components:  # it fell silent meanwhile
            pending = _Pending(action, request, now_s, None)
            self._finish(pending, _FAILED, f"{action.part.value} is no longer heard", now_s)
            return True
        waiting = self._pending.get((number, action.command))
        if waiting is not None and request is not None:
            if waiting.request is None or waiting.request.peer != request.peer:
                return False
            if waiting.request.key == request.key:
                return True
        patience = self._hub.patience
        self._pending[number, action.command] = _Pending(
            action, request, now_s + ANSWER_S * patience, now_s + AGAIN_S * patience
        )
        self._send(number, action, 0)
        return True

    def _send(self, number: int, action: Forward, confirmation: int) -> None:
        component = self._components.get(number)
        if component is None:
            return
        target, params = (component.peer.system, component.peer.component), action.params
        if action.frame is None:
            message = mavlink.MAVLink_command_long_message(*target, action.command, confirmation, *params)
        else:
            place = (int(params[4]), int(params[5]), params[6])
            message = mavlink.MAVLink_command_int_message(
                *target, action.frame, action.command, 0, 0, *params[:4], *place
            )
        self._hub.send(component.peer, message)

    def _on_ack(self, message: Any, peer: Peer, now_s: float) -> None:
        if peer.system != self._hub.system:
            return
        key = (peer.component, message.command)
        pending = self._pending.get(key)
        if pending is None:
            self._picture_answered(message, peer, now_s)
        elif message.result == _IN_PROGRESS:
            pending.due_s, pending.again_s = now_s + _WORKING_S * self._hub.patience, None
            self._answer(pending, message.result)
        else:
            del self._pending[key]
            self._finish(pending, message.result, f"{pending.action.part.value} {peer.component} refuses", now_s)

    def _finish(self, pending: _Pending, result: int, reason: str, now_s: float) -> None:
        """Tell who asked what became of it; a mission's item that failed is an event."""
        self._answer(pending, result)
        text = f"{name_of(pending.action.command)}: {reason}"
        if result == _ACCEPTED:
            return
        if pending.request is not None:
            self._hub.say(pending.request.peer, TextKind.REFUSAL, text)
        else:
            self._vessel.events.say(
                now_s, TextKind.ATTENTION, "payload_failed", f"Item {item_number(pending.action.seq)} {text}"
            )

    def _answer(self, pending: _Pending, result: int) -> None:
        if pending.request is None:
            return
        peer = pending.request.peer
        self._hub.send(
            peer,
            mavlink.MAVLink_command_ack_message(
                pending.action.command, result, target_system=peer.system, target_component=peer.component
            ),
        )

    # --- pictures --------------------------------------------------------------------------------------------------

    def _tell_of(self, shot: Shot, tick: Tick) -> None:
        """A picture: to the camera if it is on a link, and to all who listen. A camera that tells of its pictures
        itself is not spoken for."""
        component = None if shot.component is None else self._components.get(shot.component)
        if component is not None:
            target = (component.peer.system, component.peer.component)
            params = (0.0, 0.0, 1.0, float(shot.number), 0.0, 0.0, 0.0)
            command = mavlink.MAV_CMD_IMAGE_START_CAPTURE
            self._hub.send(component.peer, mavlink.MAVLink_command_long_message(*target, command, 0, *params))
        messages = [camera_trigger(shot, tick)]
        feedback = (
            None if component is not None and component.reports else camera_feedback(shot, tick, self._hub.system)
        )
        for message in (*messages, *(() if feedback is None else (feedback,))):
            packed, number = pack(message), message.get_msgId()
            for outlet in self._hub.outlets:
                if streamed(outlet, number) and not outlet.busy:
                    self._hub.send_packed(outlet, packed)

    def _picture_answered(self, message: Any, peer: Peer, now_s: float) -> None:
        picture = message.command == mavlink.MAV_CMD_IMAGE_START_CAPTURE and peer.component in self._components
        if picture and message.result not in (_ACCEPTED, _IN_PROGRESS):
            text = f"Camera {peer.component} refuses to take pictures"
            self._vessel.events.say(now_s, TextKind.ATTENTION, "camera_refuses", text)

    def _on_captured(self, message: Any, peer: Peer, now_s: float) -> None:
        if peer.system == self._hub.system and (component := self._components.get(peer.component)) is not None:
            component.reports = True

    # --- who is there ----------------------------------------------------------------------------------------------

    def _on_heartbeat(self, message: Any, peer: Peer, now_s: float) -> None:
        part = _KINDS.get(message.type, _BY_NUMBER.get(peer.component))
        if part is None or peer.system != self._hub.system or peer.component == COMPONENT:
            return
        known = self._components.get(peer.component)
        if known is None:
            self._components[peer.component] = _Component(part, peer, now_s)
            self._changed()
        else:
            known.peer, known.heard_s = peer, now_s

    def _forget(self, now_s: float) -> None:
        silent = [
            number
            for number, component in self._components.items()
            if now_s - component.heard_s > _SILENT_S * self._hub.patience or component.peer.endpoint.gone
        ]
        for number in silent:
            del self._components[number]
        if silent:
            self._changed()

    def _changed(self) -> None:
        of = {part: {number for number, one in self._components.items() if one.part is part} for part in PayloadPart}
        self._vessel.supervisor.payload.hear(of[PayloadPart.CAMERA], of[PayloadPart.GIMBAL])
