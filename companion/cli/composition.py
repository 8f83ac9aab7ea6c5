"""Puts a vessel together with what it runs in: a boat's own ports and wall clock, or a simulated boat.

Only this folder knows both `companion` and `sitl`. The lockstep rig of scenarios and tests is in `rig`.
"""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from companion.app import Surroundings, build
from companion.cli.common import complain, driven_clock
from companion.clock import PacedClock, WallClock
from companion.config.vessel import VesselConfig
from companion.core.ports import Recorder, WaitingClock
from companion.core.tick import Tick
from companion.io.mavlink.wire.links import Link
from companion.io.transport.opener import TransportOpener
from companion.loop import RealWorld, Vessel
from companion.record.state_file import StateFile

# As PX4's and ArduPilot's simulators: a ground station, an API, other programs, ArduPilot's ground stations.
SITL_LINKS = (
    "udpout:127.0.0.1:14550",
    "udpout:127.0.0.1:14540",
    "tcpin:127.0.0.1:5760",
    "tcpin:127.0.0.1:5762?dialect=ardupilot",
)
_PATIENT_S = {  # parameter: usual value, largest value
    "COM_DL_LOSS_T": (10.0, 300.0),
    "COM_RC_LOSS_T": (0.5, 10.0),
    "FOLL_LOSS_T": (0.9, 10.0),
    "FOLL_WAIT_T": (10.0, 300.0),
    "OFFB_TIMEOUT": (0.8, 60.0),
}


@dataclass(frozen=True, slots=True)
class RunOptions:
    """How to run a vessel.

    `devices`: the folder of a `companion sitl` whose ports replace the boat's. `wind`, `current`, `waves`, `water`,
    `plant`, `faults` and `seed` are for `sitl` alone, and are written as on the command line. `clock`: the address of a
    program that gives the time.
    """

    sitl: bool = False
    devices: Path | None = None
    speed: float = 1.0
    clock: str | None = None
    seed: int = 0
    wind: str | None = None
    current: str | None = None
    waves: str | None = None
    water: str | None = None
    plant: str | None = None
    faults: tuple[str, ...] = ()

    @property
    def simulated(self) -> bool:
        """Whether the boat is simulated, in this process or another."""
        return self.sitl or self.devices is not None

    @property
    def patience(self) -> float:
        """The factor on the time that the vessel waits for people and ground stations.

        They live in wall time: their time-outs must not shrink as the boat's time speeds up.
        """
        return max(1.0, self.speed)

    @property
    def defaults(self) -> Mapping[str, float]:
        """Parameters whose default changes with the speed."""
        if self.patience <= 1.0:
            return {}
        return {name: min(most_s, usual_s * self.patience) for name, (usual_s, most_s) in _PATIENT_S.items()}


def compose(
    config: VesselConfig, options: RunOptions, links: Sequence[Link], state: StateFile, log_folder: Path
) -> tuple[Vessel, WaitingClock]:
    """The vessel of `config` on these links, and its clock. Raises ConfigError, TransportError, OSError."""
    return (_compose_simulated if options.sitl else _compose_real)(config, options, links, state, log_folder)


def judge(config: VesselConfig, options: RunOptions) -> None:
    """Raise ConfigError for weather, water, a plant or a fault that makes no sense, before anything opens."""
    if options.sitl:
        from sitl.environment import parse_directed
        from sitl.faults import Faults
        from sitl.gusts import parse_wind
        from sitl.rough_water import is_rough
        from sitl.sea_state import parse_sea
        from sitl.world import chosen_plant

        if options.wind is not None:
            parse_wind(options.wind)
        if options.current is not None:
            parse_directed(options.current, "current")
        parse_sea(options.waves or "")
        if config.sitl is not None:
            is_rough(options.water, config.sitl)
        chosen_plant(config, options.plant)
        Faults(options.faults, config)


def _compose_real(
    config: VesselConfig, options: RunOptions, links: Sequence[Link], state: StateFile, log_folder: Path
) -> tuple[Vessel, WaitingClock]:
    clock = driven_clock(options.clock, time.time_ns()) if options.clock else WallClock(options.speed)
    opener = TransportOpener(options.devices)
    around = Surroundings(
        clock=clock,
        opener=opener,
        world=RealWorld(),
        links=links,
        state=state,
        log_folder=log_folder,
        durable_log=True,
        patient_log=True,
        beside=True,
        manifest=_manifest(options),
        defaults=options.defaults,
        patience=options.patience,
        stations_time_unix_ns=time.time_ns if options.devices is not None else None,
        network=opener,
    )
    return build(config, around), clock


def _compose_simulated(
    config: VesselConfig, options: RunOptions, links: Sequence[Link], state: StateFile, log_folder: Path
) -> tuple[Vessel, WaitingClock]:
    from sitl.camera import PictureLog
    from sitl.truth_log import TruthLog
    from sitl.world import EPOCH_UNIX_NS, World, WorldConditions

    conditions = WorldConditions(
        seed=options.seed,
        wind=options.wind,
        current=options.current,
        waves=options.waves,
        water=options.water,
        faults=options.faults,
        plant=options.plant,
    )
    world = World(config, conditions)
    driven = driven_clock(options.clock, EPOCH_UNIX_NS) if options.clock else None
    clock = driven or PacedClock(options.speed, EPOCH_UNIX_NS)
    around = Surroundings(
        clock=clock,
        opener=world,
        world=world,
        links=links,
        state=state,
        log_folder=log_folder,
        durable_log=True,
        beside=True,
        manifest=_manifest(options),
        defaults=options.defaults,
        patience=options.patience,
        stations_time_unix_ns=time.time_ns,
        network=TransportOpener(),
    )
    vessel = build(config, around)
    truth = TruthLog(log_folder, world, tuple(thruster.name for thruster in config.thrusters))
    vessel.add_recorder(WhileThereIsSpace(truth, "truth.csv"))
    if world.cameras:
        vessel.add_recorder(WhileThereIsSpace(PictureLog(log_folder, world.cameras), "pictures.csv"))
    return vessel, clock


class TruthRecorder(Recorder, Protocol):
    """What keeps the simulation's own truth."""

    def write(self) -> None:
        """Write the present truth, without a tick."""
        ...


class WhileThereIsSpace:
    """A `TruthRecorder`: where the medium takes no more, it ends with a word, and the boat sails on as a real one does.
    In lockstep, where the truth is what counts, such an error ends the run."""

    def __init__(self, recorder: TruthRecorder, name: str) -> None:
        self._recorder: TruthRecorder | None = recorder
        self._name = name

    def record(self, tick: Tick) -> None:
        """Take one tick, as long as that is possible."""
        self._take(lambda recorder: recorder.record(tick))

    def write(self) -> None:
        """Write the present truth, as long as that is possible."""
        self._take(lambda recorder: recorder.write())

    def _take(self, write: Callable[[TruthRecorder], None]) -> None:
        if self._recorder is None:
            return
        try:
            write(self._recorder)
        except OSError as error:
            complain(f"{self._name} ends here: {error.strerror or error}; the boat sails on")
            self.close()

    def close(self) -> None:
        """Close the file; what does not fit is lost."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            with contextlib.suppress(OSError):
                recorder.close()


def _manifest(options: RunOptions) -> dict[str, object]:
    return {"command": " ".join(sys.argv), "seed": options.seed if options.sitl else None}
