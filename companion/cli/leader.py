"""`companion leader CONFIG`: the leader module, the program on the lead boat."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.cli.common import (
    Interrupt,
    add_clock_to,
    boat_folder,
    complain,
    driven_clock,
    is_over,
    judge_log_limit,
    judge_logs,
    new_folder,
    tell_fault,
)
from companion.clock import WallClock
from companion.core.ports import Clock
from companion.io.known_time import KnownTime, host_synchronised
from companion.io.mavlink.wire.links import Link, open_links
from companion.io.mavlink.wire.signing import Policy, Signing, SigningState
from companion.io.mavlink.wire.stream_memory import SharedStreamMemory
from companion.io.service_manager import ServiceManager, service_manager
from companion.io.transport.opener import TransportOpener
from companion.leader_module.app import Display, LeaderSurroundings, build_leader, load_leader
from companion.leader_module.config import LeaderConfig, bundled_leaders
from companion.leader_module.console import Console
from companion.loop import run
from companion.record.retention import keep_logs
from companion.record.state_file import StateFile
from companion.record.writer import ThreadWriter


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    leader = commands.add_parser(
        "leader", help="the module on a lead boat: sends the follower its position and what its crew asks for"
    )
    leader.add_argument(
        "config",
        metavar="CONFIG",
        help=f"a bundled name ({', '.join(bundled_leaders())}) or a TOML file of a leader module",
    )
    leader.add_argument(
        "--link", action="append", metavar="URL", help="towards the follower; replaces the file's links"
    )
    leader.add_argument("--state", type=Path, metavar="DIR", help="folder of the signing key, for links that use one")
    leader.add_argument("--log", type=Path, metavar="DIR", help="folder in which the log folder is made")
    leader.add_argument(
        "--log-limit",
        type=int,
        metavar="MB",
        help="delete the oldest log folders there while all together are larger",
    )
    leader.add_argument("--duration", type=float, metavar="S", help="end after this long")
    add_clock_to(leader)
    leader.set_defaults(command=_leader)


def _leader(arguments: argparse.Namespace) -> int:
    judge_log_limit(arguments.log_limit)
    config = load_leader(arguments.config)
    clock = driven_clock(arguments.clock, time.time_ns()) if arguments.clock else WallClock()
    logs = boat_folder(config.name) / "logs" if arguments.log is None else arguments.log
    judge_logs(logs, sitl=False)
    log_folder = new_folder(logs, f"{config.name}-{time.strftime('%Y%m%d-%H%M%S')}")
    urls = tuple(arguments.link or config.links)
    links = open_links((*urls, *config.local_links))
    towards, local = links[: len(urls)], links[len(urls) :]
    interrupt = Interrupt()
    print(f"leader module {config.title or config.name}, system {config.system_id}, of follower {config.follower}")
    print(f"links: {', '.join((*urls, *config.local_links))}")
    print(f"log:   {log_folder}")
    print("keys:  m Manual, r Remote, a Autonomous; Ctrl-C ends it", flush=True)
    state = _state(config, arguments, links)
    console = Console()
    manager = service_manager(os.environ)
    display = console if manager is None else Reporting(console, manager)
    retention = keep_logs(logs, arguments.log_limit, log_folder, complain)
    try:
        module = build_leader(
            config,
            LeaderSurroundings(
                clock, TransportOpener(), towards, local, display, log_folder, True, signing=_signing(state, clock)
            ),
        )
        module.containment.report = tell_fault
        try:
            run(module, clock, lambda: interrupt.received or is_over(clock, arguments.duration))
        finally:
            module.close()
    finally:
        console.close()
        if manager is not None:
            manager.close()
        if state is not None:
            state.close()
        if retention is not None:
            retention.close()
    return 0


class Reporting:
    """A display whose status line is the module's sign of life to systemd, too."""

    def __init__(self, display: Display, manager: ServiceManager) -> None:
        self._display = display
        self._manager = manager

    def fileno(self) -> int | None:
        """See `Display`."""
        return self._display.fileno()

    def typed(self) -> str:
        """See `Display`."""
        return self._display.typed()

    def show(self, line: str, now_s: float) -> None:
        """See `Display`."""
        self._manager.alive(now_s, line)
        self._display.show(line, now_s)

    def say(self, text: str) -> None:
        """See `Display`."""
        self._display.say(text)


def _state(config: LeaderConfig, arguments: argparse.Namespace, links: Sequence[Link]) -> StateFile | None:
    """The module's state folder, locked for this process; None where no link uses signatures."""
    if all(link.guard.options.signing is Policy.OFF for link in links):
        return None
    state = StateFile(boat_folder(config.name) / "state" if arguments.state is None else arguments.state, complain)
    state.write_with(ThreadWriter(state.directory, lambda: None))
    return state


def _signing(state: StateFile | None, clock: Clock) -> Signing | None:
    if state is None:
        return None
    kept, warnings = state.load_signing()
    for text in warnings:
        complain(text)

    def save(new: SigningState) -> None:
        state.save_signing(new.key, new.horizon)

    known = KnownTime(host_synchronised, clock.time_unix_ns)
    memory = SharedStreamMemory(state.directory)
    return Signing(clock.time_unix_ns, SigningState(*kept), save, known.unix_ns, memory)
