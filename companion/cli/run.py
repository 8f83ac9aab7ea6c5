"""`companion run VESSEL`: the autopilot of one boat, real or simulated."""

from __future__ import annotations

import argparse
import gc
import math
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from companion.app import load_vessel, program_version
from companion.cli import realtime
from companion.cli.common import (
    Interrupt,
    UsageError,
    add_clock_to,
    boat_folder,
    complain,
    is_over,
    judge_log_limit,
    judge_logs,
    judge_time,
    new_folder,
    outlive_outputs,
    print_warnings,
    tell_fault,
    typed,
)
from companion.cli.composition import SITL_LINKS, RunOptions, compose, judge
from companion.cli.console import add_feed, add_option_to, start_console, stop_console
from companion.cli.scripts import keep_scripts, script_links
from companion.cli.terminal import Terminal, journal_of, screen_on
from companion.cli.trial_results import FileTrials, IdentifyProcess
from companion.cli.warm_up import WarmUp
from companion.config import vessel as config_module
from companion.config.vessel import HomeConfig, VesselConfig, find
from companion.core.decision import ModeId, TextKind
from companion.core.ports import WaitingClock
from companion.io.mavlink.wire.exposure import exposed_warnings
from companion.io.mavlink.wire.links import open_links
from companion.io.service_manager import service_manager
from companion.loop import Punctuality, Vessel, run
from companion.record.retention import keep_logs
from companion.record.state_file import StateFile

_STANDARD_OUTPUT = 1
_SWITCH_S = 1e-4  # for which another thread may compute before the control thread has its turn


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    run_ = commands.add_parser("run", help="run a vessel, real or simulated")
    add = run_.add_argument
    add("vessel", metavar="VESSEL", help=f"a bundled name ({', '.join(config_module.bundled())}) or a TOML file")
    add("--sitl", action="store_true", help="with the simulated boat in place of its devices")
    add("--devices", type=Path, metavar="DIR", help="with the devices of a `companion sitl`: /dev/NAME is DIR/NAME")
    add("--speed", type=float, default=1.0, metavar="N", help="with --sitl or --devices: N times as fast as the clock")
    add(
        "--link",
        action="append",
        metavar="URL",
        help="replaces the vessel's links; udpout:, udpin:, tcpin:, tcpout:, serial:",
    )
    add("--home", metavar="LAT,LON,HEADING_DEG", help="replaces the vessel's home")
    add("--state", type=Path, metavar="DIR", help="folder of parameters and plans")
    add("--log", type=Path, metavar="DIR", help="folder in which the log folder is made")
    add("--log-limit", type=int, metavar="MB", help="delete the oldest log folders there while all together are larger")
    add("--seed", type=int, default=0, help="with --sitl: seed of all noise")
    add("--wind", metavar="MPS@FROM_DEG", help="with --sitl")
    add("--current", metavar="MPS@TOWARDS_DEG", help="with --sitl")
    add("--waves", metavar="HS[@FROM_DEG][/TP_S]", help="with --sitl: sea state by height, direction, peak period")
    add("--water", metavar="KIND", help="with --sitl: usual, or rough: all that water, wind and sensors do to a boat")
    add("--plant", metavar="NAME", help="with --sitl: another of the vessel's simulated hulls, `[sitl.plants.NAME]`")
    add("--fault", action="append", default=[], metavar="NAME[:DEVICE][=SIZE]@T_S[+DURATION_S]", help="with --sitl")
    add("--realtime", action="store_true", help="before all other programs (SCHED_FIFO), with its memory locked")
    add("--duration", type=float, metavar="S", help="end after this long, in the boat's time")
    add_option_to(run_)
    add_clock_to(run_)
    run_.set_defaults(command=_run)


def _run(arguments: argparse.Namespace) -> int:
    _check_arguments(arguments)
    _tell_of_no_devices(arguments.devices)
    config = load_vessel(arguments.vessel)
    if arguments.home:
        config = config_module.with_home(config, _home(arguments.home))
    options = _options(arguments)
    judge(config, options)
    outlive_outputs()
    interrupt = Interrupt()
    refused = realtime.before_threads() if arguments.realtime else []
    logs = boat_folder(config.name, options.simulated) / "logs" if arguments.log is None else arguments.log
    judge_logs(logs, options.sitl)
    log_folder = new_folder(logs, f"{config.name}-{time.strftime('%Y%m%d-%H%M%S')}")
    kept = boat_folder(config.name, options.simulated) / "state" if arguments.state is None else arguments.state
    state = StateFile(kept, complain)
    default_links = SITL_LINKS if options.sitl else config.links
    links = open_links(arguments.link or default_links, options.patience, None if arguments.link else complain)
    private = script_links(config.scripts)
    vessel, clock = compose(config, options, [*links, *private], state, log_folder)
    identifies = IdentifyProcess(find(arguments.vessel), log_folder)
    model = _keep_trials(vessel, find(arguments.vessel), identifies)
    feed = add_feed(vessel, [link.name for link in links], state.directory)
    if (manager := service_manager(os.environ)) is not None:
        vessel.add_recorder(manager)
    retention = keep_logs(logs, arguments.log_limit, log_folder, complain)
    names = [link.name for link in links]
    _print_banner(config, options, names, state, log_folder, model)
    print_warnings((*exposed_warnings(names), *refused, *vessel.supervisor.trial_duty.kept()))
    _tell_refused(vessel, refused, clock.now_s())
    punctuality = Punctuality()
    terminal = _terminal(vessel, names, punctuality, options.patience)
    console = start_console(arguments.console, state.directory, arguments.control) if feed else None
    keep_scripts(vessel, find(arguments.vessel), private, state.directory, log_folder, clock.now_s())
    try:
        if arguments.realtime and not refused:
            print_warnings(realtime.control_thread())
            vessel.add_recorder(realtime.Priorities())
        _run_until_stopped(vessel, clock, lambda: interrupt.received or is_over(clock, arguments.duration), punctuality)
    finally:
        vessel.close()
        state.close()
        stop_console(console)
        if retention is not None:
            retention.close()
    if not terminal.stuck and identifies.unfinished:
        again = typed("identify", log_folder, "--vessel", arguments.vessel)
        print(f"The boat was still identifying itself from its trial; `{again}` does it", flush=True)
    if not terminal.stuck and not vessel.restart_requested:
        summary = terminal.summary
        _print_summary(summary.lines(None if options.sitl else punctuality), log_folder, ModeId.TRIAL in summary.modes)
    _restart_if_requested(vessel)
    return 0


def _keep_trials(vessel: Vessel, vessel_file: Path, process: IdentifyProcess) -> str | None:
    """Identify after each trial, and keep what is accepted, beside the vessel's file. Returns the overlay in force."""
    trials = FileTrials(vessel_file, process, vessel.worker, process.close)
    vessel.supervisor.trial_duty.results = trials
    vessel.add_recorder(trials)
    return trials.in_force


def _tell_refused(vessel: Vessel, refused: Sequence[str], now_s: float) -> None:
    """Announce what the computer does not grant."""
    for text in refused:
        vessel.events.say(now_s, TextKind.ATTENTION, "realtime", f"Computer {text.partition(';')[0]}")


def _restart_if_requested(vessel: Vessel) -> None:
    if vessel.restart_requested:
        os.execv(sys.executable, [sys.executable, "-m", "companion", *sys.argv[1:]])


def _terminal(vessel: Vessel, links: Sequence[str], punctuality: Punctuality, patience: float) -> Terminal:
    """Shows the vessel's run on standard output."""
    out = _STANDARD_OUTPUT
    terminal = Terminal(
        screen_on(out, os.environ),
        links,
        lambda: vessel.sources.get("heading"),
        lambda: punctuality.late,
        journal_of(os.environ, out),
        0.5 * patience,
    )
    vessel.add_recorder(terminal)
    return terminal


def _run_until_stopped(
    vessel: Vessel, clock: WaitingClock, asked_to_stop: Callable[[], bool], punctuality: Punctuality
) -> None:
    """Tick until a signal, the end of the duration, or a restart that a ground station asks for."""
    gc.collect()
    gc.freeze()
    sys.setswitchinterval(_SWITCH_S)
    vessel.containment.report = tell_fault
    vessel.add_recorder(WarmUp(vessel))
    run(vessel, clock, lambda: asked_to_stop() or vessel.restart_requested, punctuality)


def _check_arguments(arguments: argparse.Namespace) -> None:
    """Raises UsageError for values, and for combinations of options, that make no sense."""
    judge_time(arguments.speed, arguments.duration)
    judge_log_limit(arguments.log_limit)
    if arguments.sitl and arguments.devices is not None:
        raise UsageError("--sitl has its own devices: leave out --devices, or --sitl for those of a `companion sitl`")
    simulated = arguments.sitl or arguments.devices is not None
    for flag in () if arguments.sitl else ("wind", "current", "waves", "water", "plant", "fault"):
        if getattr(arguments, flag):
            reason = "belongs to `companion sitl`" if simulated else "needs --sitl: a real boat has its own weather"
            raise UsageError(f"--{flag} {reason}")
    _check_time(arguments, simulated)
    _check_console(arguments)


def _check_console(arguments: argparse.Namespace) -> None:
    if arguments.console is not None and not 0 <= arguments.console <= 65535:
        raise UsageError(f"--console {arguments.console}: 0 to 65535")
    if arguments.control and arguments.console is None:
        raise UsageError("--control needs --console: it lets that page command the boat")


def _tell_of_no_devices(folder: Path | None) -> None:
    if folder is not None and not folder.is_dir():
        print(f"--devices {folder}: no such folder yet; a `companion sitl` makes it, and prints its name", flush=True)


def _check_time(arguments: argparse.Namespace, simulated: bool) -> None:
    if arguments.clock and not simulated:
        raise UsageError("--clock needs --sitl or --devices: a real boat runs in real time")
    if not simulated and arguments.speed != 1.0:
        raise UsageError(f"--speed {arguments.speed:g}: needs --sitl or --devices; a real boat runs in real time")


def _options(arguments: argparse.Namespace) -> RunOptions:
    return RunOptions(
        sitl=arguments.sitl,
        devices=arguments.devices,
        speed=arguments.speed,
        clock=arguments.clock,
        seed=arguments.seed,
        wind=arguments.wind,
        current=arguments.current,
        waves=arguments.waves,
        water=arguments.water,
        plant=arguments.plant,
        faults=tuple(arguments.fault),
    )


def _home(text: str) -> HomeConfig:
    """`63.4389,10.3990,0`. Raises UsageError, also for two numbers: `63,4` is one with a decimal comma."""
    try:
        lat_deg, lon_deg, heading_deg = (float(part) for part in text.split(","))
    except ValueError as error:
        raise UsageError(f"--home {text}: write LAT,LON,HEADING_DEG, as 63.4389,10.3990,0") from error
    on_earth = -89.0 <= lat_deg <= 89.0 and -180.0 <= lon_deg <= 180.0
    if not on_earth or not math.isfinite(heading_deg):
        raise UsageError(f"--home {text}: no such place; write LAT,LON,HEADING_DEG")
    return HomeConfig(lat_deg, lon_deg, math.radians(heading_deg))


def _print_banner(
    config: VesselConfig,
    options: RunOptions,
    links: Sequence[str],
    state: StateFile,
    log_folder: Path,
    model: str | None,
) -> None:
    how = f"simulated, {options.speed:g} times real time" if options.sitl else "on its own devices"
    if options.devices is not None:
        how = f"on simulated devices in {options.devices}, {options.speed:g} times real time"
    print(f"USV companion {program_version()}: {config.title}, {how}")
    print(f"links: {', '.join(links)}")
    print(f"state: {state.directory}")
    print(f"log:   {log_folder}")
    if model is not None:
        print(f"model: {model}, as accepted after a sea trial")
    print("Ctrl-C ends it", flush=True)


def _print_summary(lines: Sequence[str], log_folder: Path, had_trial: bool) -> None:
    for line in lines:
        print(line)
    print(f"log:   {log_folder}")
    if had_trial:
        print(f"`{typed('trial', 'report', log_folder)}` shows what the trial found")
    print(f"`{typed('report', log_folder)}` shows it", flush=True)
