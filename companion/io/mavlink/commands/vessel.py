"""Commands that change what the vessel does: arming, modes, go-to, mission, speed, home, storage, restart."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial

from companion.core.decision import Home, ModeId, Outcome, Result, TextKind
from companion.io.mavlink.commands.request import (
    DONE,
    Answer,
    CommandHandler,
    CommandRequest,
    denied,
    is_place,
    not_now,
)
from companion.io.mavlink.commands.table import ROWS
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Hub, Peer
from companion.loop import Vessel
from companion.mission.jumps import marked
from companion.mission.plan import PlanKind
from companion.modes.table import DECLARATIONS

_FORCE = frozenset({2989.0, 21196.0})
_STANDARD_MODES = {declared.standard_mode: mode for mode, declared in DECLARATIONS.items() if declared.standard_mode}
_GROUND_SPEEDS = (0.0, 1.0)  # SPEED_TYPE_AIRSPEED means the same on a boat
_NO_CHANGE, _DEFAULT = -1.0, -2.0
_RESET = 2
_RESTART = 1

# Done twice, these would do something else the second time; all others end as done once.
ONCE = frozenset(
    {
        mavlink.MAV_CMD_MISSION_START,
        mavlink.MAV_CMD_DO_SET_HOME,
        mavlink.MAV_CMD_DO_SET_MISSION_CURRENT,
        mavlink.MAV_CMD_DO_JUMP_TAG,
        mavlink.MAV_CMD_PREFLIGHT_STORAGE,
        mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN,
        *(row.number for row in ROWS if row.once),
    }
)


class VesselCommands:
    """`commands`: number → what is done. Every request goes to the supervisor, whose outcome is the answer."""

    def __init__(self, hub: Hub, vessel: Vessel) -> None:
        self._hub = hub
        self._vessel = vessel
        self._supervisor = vessel.supervisor
        self.commands: Mapping[int, CommandHandler] = {
            mavlink.MAV_CMD_COMPONENT_ARM_DISARM: self._arm_disarm,
            mavlink.MAV_CMD_DO_SET_MODE: self._do_set_mode,
            mavlink.MAV_CMD_DO_SET_STANDARD_MODE: self._set_standard_mode,
            mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: self._return,
            mavlink.MAV_CMD_NAV_LOITER_UNLIM: self._loiter,
            mavlink.MAV_CMD_MISSION_START: self._mission_start,
            mavlink.MAV_CMD_DO_REPOSITION: self._reposition,
            mavlink.MAV_CMD_DO_PAUSE_CONTINUE: self._pause_continue,
            mavlink.MAV_CMD_DO_CHANGE_SPEED: self._change_speed,
            mavlink.MAV_CMD_DO_SET_HOME: self._set_home,
            mavlink.MAV_CMD_DO_SET_MISSION_CURRENT: self._set_mission_current,
            mavlink.MAV_CMD_DO_JUMP_TAG: self._jump_to_tag,
            mavlink.MAV_CMD_PREFLIGHT_STORAGE: self._storage,
            mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: self._restart,
            mavlink.MAV_CMD_DO_FLIGHTTERMINATION: self._terminate,
            **{row.number: partial(row.handler, self._supervisor) for row in ROWS},
        }

    # --- arming and modes ------------------------------------------------------------------------------------------

    def _arm_disarm(self, request: CommandRequest) -> Outcome | Answer:
        """Arm or disarm.

        param1: 1 arms, 0 disarms.
        param2: 2989 or 21196: by force.
        """
        force = request.params[1] in _FORCE
        match request.whole(1):
            case 1:
                return self._supervisor.arm(request.now_s, force)
            case 0:
                return self._supervisor.disarm(request.now_s, force)
        return denied("param 1 of arming should be 0 or 1")

    def set_mode(self, custom_mode: int, peer: Peer, now_s: float) -> Outcome | Answer:
        """The mode of a number in the peer's persona."""
        offered = frozenset(mode.declaration.id for mode in self._supervisor.modes if mode.declaration.selectable)
        mode = peer.endpoint.persona.mode(custom_mode, offered)
        if mode is None:
            return denied(f"no mode number {custom_mode} here")
        if (
            mode is ModeId.OFFBOARD
            and peer.endpoint.persona.offboard_may_wait
            and self._supervisor.offboard_fault(now_s) is not None
        ):
            outcome = self._supervisor.guided.choose(now_s)
        else:
            outcome = self._supervisor.request_mode(mode, now_s, peer.endpoint.persona.orders.get(custom_mode))
        if outcome.accepted:
            self._hub.modes_asked[peer.endpoint.persona] = custom_mode
        return outcome

    def _do_set_mode(self, request: CommandRequest) -> Outcome | Answer:
        """Another mode, by the numbers of this link's persona.

        param1: MAV_MODE_FLAG_CUSTOM_MODE_ENABLED (1) must be set.
        param2: Custom mode: ArduPilot's number; on px4 and generic links the main mode, or the whole number.
        param3: Sub mode; px4 and generic only.
        """
        base, main, sub = request.whole(1), request.whole(2), request.whole_or(3, 0)
        if base is None or main is None or sub is None:
            return denied("mode numbers should be whole")
        if not (0 <= main <= 0xFFFFFFFF and 0 <= sub <= 0xFF):
            return denied("mode numbers should be whole")
        if not base & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED:
            return denied("base modes alone are not understood")
        if request.peer.endpoint.persona.packs_main_and_sub:
            number = main << 16 | sub << 24 if main <= 0xFF else main
        elif sub:
            return denied("this link takes ArduPilot's mode numbers")
        else:
            number = main
        return self.set_mode(number, request.peer, request.now_s)

    def _set_standard_mode(self, request: CommandRequest) -> Outcome | Answer:
        """Another mode, by MAV_STANDARD_MODE.

        param1: 1 Hold, 5 RTL, 6 Mission.
        """
        number = request.whole(1)
        mode = None if number is None else _STANDARD_MODES.get(number)
        if mode is None:
            return Answer(Outcome(Result.FAILED, "no such standard mode"))
        return self._supervisor.request_mode(mode, request.now_s)

    def _return(self, request: CommandRequest) -> Outcome | Answer:
        """RTL."""
        return self._supervisor.request_mode(ModeId.RTL, request.now_s)

    def _terminate(self, request: CommandRequest) -> Outcome | Answer:
        """Stop the thrusters and disarm, whatever the boat does.

        param1: 1 terminates, 0 does nothing.
        """
        match request.whole(1):
            case 1:
                return self._supervisor.terminate(request.now_s)
            case 0:
                return DONE
        return denied("param 1 of termination should be 0 or 1")

    # --- go-to and mission -----------------------------------------------------------------------------------------

    def _reposition(self, request: CommandRequest) -> Outcome | Answer:
        """Go to a point and hold there.

        param1: Speed, m/s. 0, negative or NaN: the usual one.
        param2: Bit 0: change to Hold. Without it the boat must be in Hold.
        param4: Heading, rad. NaN: none; on an ardupilot link 0 too.
        param5: Latitude. NaN in params 5 and 6: hold here.
        param6: Longitude.
        """
        if not request.frame_is_global:
            return denied(f"frame {request.frame} is not a global one")
        changes = request.whole_or(2, 0)
        if changes is None:
            return denied("param 2 of go-to should be whole")
        if not changes & 1 and self._supervisor.status(request.now_s).mode is not ModeId.HOLD:
            return not_now("go-to: allow it to change the mode, or choose Hold")
        lat_deg, lon_deg = request.place
        if math.isnan(lat_deg) and math.isnan(lon_deg):
            return self._supervisor.hold_here(request.now_s)
        if not is_place(lat_deg, lon_deg):
            return denied("no such place")
        speed_mps, yaw_rad = request.params[0], request.params[3]
        no_yaw = not math.isfinite(yaw_rad) or (yaw_rad == 0.0 and request.peer.endpoint.persona.zero_yaw_is_unset)
        no_speed = not math.isfinite(speed_mps) or speed_mps <= 0.0
        return self._supervisor.go_to(
            lat_deg, lon_deg, None if no_yaw else yaw_rad, None if no_speed else speed_mps, request.now_s
        )

    def _loiter(self, request: CommandRequest) -> Outcome | Answer:
        """Hold, as pymavlink's `set_mode_loiter` asks for it. Radius and heading are ignored.

        param5: Latitude of the place to go to and hold at. NaN or 0 in params 5 and 6: here.
        param6: Longitude.
        """
        if not request.frame_is_global:
            return denied(f"frame {request.frame} is not a global one")
        if request.names_no_place:
            return self._supervisor.hold_here(request.now_s)
        if not is_place(*request.place):
            return denied("no such place")
        return self._supervisor.go_to(*request.place, None, None, request.now_s)

    def _pause_continue(self, request: CommandRequest) -> Outcome | Answer:
        """Pause or continue a mission.

        param1: 0 pauses and holds here, 1 continues.
        """
        match request.whole(1):
            case 0:
                return self._supervisor.pause(request.now_s)
            case 1:
                return self._supervisor.resume(request.now_s)
        return denied("param 1 of pause should be 0 or 1")

    def _mission_start(self, request: CommandRequest) -> Outcome | Answer:
        """Mission mode. It does not arm.

        param1: Sequence number of the first item. 0 in both params, or NaN: from the current item.
        param2: Last item; ignored.
        """
        first, last = request.whole_or(1, 0), request.whole_or(2, 0)
        if first is None or last is None or first < 0:
            return denied("item numbers should be whole")
        if first == 0 and last == 0:
            return self._supervisor.start_mission(None, request.now_s)
        return self._supervisor.start_mission(self._item(first, request.peer), request.now_s)

    def _set_mission_current(self, request: CommandRequest) -> Outcome | Answer:
        """Make an item of the mission the current one.

        param1: Sequence number of the item; −1: the present one goes on.
        param2: 1 forgets the jumps taken.
        """
        seq, reset = request.whole(1), request.whole_or(2, 0)
        if seq is None or seq < -1 or reset not in (0, 1):
            return denied("no such item")
        return self._make_current(None if seq == -1 else self._item(seq, request.peer), bool(reset), request)

    def _jump_to_tag(self, request: CommandRequest) -> Outcome | Answer:
        """Make the mark (JUMP_TAG) of the mission with this number the current item.

        param1: Number of the mark.
        param2: Repeat count; ignored: a command jumps once.
        """
        tag = request.whole(1)
        seq = None if tag is None else marked(self._vessel.plans.items(PlanKind.MISSION), tag)
        if seq is None:
            return denied(f"no JUMP_TAG {request.params[0]:g} in the mission")
        return self._make_current(seq, False, request)

    def _make_current(self, seq: int | None, reset: bool, request: CommandRequest) -> Outcome | Answer:
        outcome = self._supervisor.set_current(seq, reset, request.now_s)
        if not outcome.accepted:
            return outcome
        self._hub.announce(request.now_s, mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)
        return Answer(outcome, stored=self._vessel.storage.progress())

    @staticmethod
    def _item(seq: int, peer: Peer) -> int:
        """An item's number in the vessel's plan; home itself stands for the first."""
        return max(0, seq - peer.endpoint.persona.first_item)

    def _change_speed(self, request: CommandRequest) -> Outcome | Answer:
        """Speed in modes that steer by themselves, until the mission changes it or the boat is disarmed.

        param1: 1 or 0: ground speed.
        param2: Speed, m/s; −1: no change; −2: WP_SPEED.
        """
        kind, speed_mps = request.params[0], request.params[1]
        if kind not in _GROUND_SPEEDS:
            return denied("a boat has a ground speed only")
        if speed_mps == _NO_CHANGE:
            return DONE
        if speed_mps == _DEFAULT:
            return self._supervisor.change_speed(None, request.now_s)
        if not math.isfinite(speed_mps) or speed_mps <= 0.0:
            return denied("the speed should be above 0")
        return self._supervisor.change_speed(speed_mps, request.now_s)

    # --- home, storage, restart ------------------------------------------------------------------------------------

    def _set_home(self, request: CommandRequest) -> Outcome | Answer:
        """Another home.

        param1: 1: where the boat is; 0: the position given.
        param4: Heading, degrees. 0 or NaN: none.
        param5: Latitude.
        param6: Longitude.
        param7: Altitude, m. NaN: as before.
        """
        match request.whole(1):
            case 1:
                result: Outcome | Answer = self._supervisor.set_home(None, request.now_s)
            case 0:
                result = self._set_home_at(request)
            case _:
                return denied("param 1 of set home should be 0 or 1")
        if not isinstance(result, Outcome) or not result.accepted:
            return result
        self._hub.announce(request.now_s, mavlink.MAVLINK_MSG_ID_HOME_POSITION)
        return Answer(result, stored=self._vessel.storage.progress())

    def _set_home_at(self, request: CommandRequest) -> Outcome | Answer:
        lat_deg, lon_deg = request.place
        if not request.frame_is_global or not is_place(lat_deg, lon_deg):
            return denied("no such place")
        altitude_m, yaw_deg = request.params[6], request.params[3]
        known = self._supervisor.status(request.now_s).home
        if not math.isfinite(altitude_m):
            altitude_m = 0.0 if known is None else known.altitude_m
        given = math.isfinite(yaw_deg) and yaw_deg != 0.0  # most clients fill with 0 what they do not mean
        return self._supervisor.set_home(
            Home(lat_deg, lon_deg, altitude_m, math.radians(yaw_deg) if given else None), request.now_s
        )

    def _storage(self, request: CommandRequest) -> Outcome | Answer:
        """Parameters are kept as they are set: reading and writing do nothing.

        param1: 2 resets all parameters to the defaults of the vessel, while disarmed. −1, 0 and 1 do nothing.
        """
        match request.whole_or(1, -1):
            case -1 | 0 | 1:
                return DONE
            case 2:
                if self._supervisor.status(request.now_s).armed:
                    return not_now("parameters are reset while disarmed only")
                self._vessel.parameters.reset()
                return Answer(DONE.outcome, sets_parameters=True)
        return denied("param 1 of storage should be 0 to 2")

    def _restart(self, request: CommandRequest) -> Outcome | Answer:
        """Restart the companion, while disarmed. The process begins anew by itself, as a service and in a terminal.

        param1: 1.
        """
        if request.whole(1) != _RESTART:
            return denied("param 1 of restart should be 1")
        if self._supervisor.status(request.now_s).armed:
            return denied("restart while disarmed only")
        self._vessel.events.say(request.now_s, TextKind.ROUTINE, "restart", "Restarting: back in a few seconds")
        self._vessel.request_restart()
        return DONE
