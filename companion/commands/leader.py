"""`companion leader CONFIG`: the module on the lead boat."""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.clock import WallClock
from companion.commands.folders import fresh, kept_in
from companion.config.leader import LeaderConfig, bundled_leaders
from companion.io.console import Console
from companion.io.mavlink.links import Link, open_links
from companion.io.mavlink.signing import Policy, Signing, SigningState
from companion.io.transport import TransportOpener
from companion.leader_app import LeaderSurroundings, build_leader, load_leader
from companion.loop import run
from companion.record.state_file import StateFile


def add_to(commands: Any) -> None:
    """`commands` as argparse's `add_subparsers` gives it."""
    leader = commands.add_parser("leader", help="the module on a lead boat: tells the follower where it is and what its crew asks")
    leader.add_argument("config", metavar="CONFIG", help=f"a bundled name ({', '.join(bundled_leaders())}) or a TOML file of a leader module")
    leader.add_argument("--link", action="append", metavar="URL", help="towards the follower, in place of the file's links")
    leader.add_argument("--state", type=Path, metavar="DIR", help="where the key of signatures is kept, for links that ask for them")
    leader.add_argument("--log", type=Path, metavar="DIR", help="where the log folder is made")
    leader.add_argument("--duration", type=float, metavar="S", help="end after this long")
    leader.set_defaults(command=_leader)


def _leader(arguments: argparse.Namespace) -> int:
    config = load_leader(arguments.config)
    clock = WallClock()
    log_folder = fresh(kept_in(config.name) / "logs" if arguments.log is None else arguments.log, f"{config.name}-{time.strftime('%Y%m%d-%H%M%S')}")
    urls = tuple(arguments.link or config.links)
    links = open_links((*urls, *config.local_links))
    towards, local = links[: len(urls)], links[len(urls) :]
    stop = _Stop(clock, arguments.duration)
    print(f"leader module {config.title or config.name}, system {config.system_id}, of follower {config.follower}")
    print(f"links: {', '.join((*urls, *config.local_links))}")
    print(f"log:   {log_folder}")
    print("keys:  m Manual, r Remote, a Autonomous; Ctrl-C ends it", flush=True)
    state = _state(config, arguments, links)
    console = Console()
    try:
        module = build_leader(
            config, LeaderSurroundings(clock, TransportOpener(), towards, local, console, log_folder, True, _signing(state, clock))
        )
        try:
            run(module, clock, stop)
        finally:
            module.close()
    finally:
        console.close()
        if state is not None:
            state.close()
    return 0


def _state(config: LeaderConfig, arguments: argparse.Namespace, links: Sequence[Link]) -> StateFile | None:
    """Held by one module at a time; None where no link needs it."""
    if all(link.guard.options.signing is Policy.OFF for link in links):
        return None
    return StateFile(kept_in(config.name) / "state" if arguments.state is None else arguments.state, _complain)


def _signing(state: StateFile | None, clock: WallClock) -> Signing | None:
    if state is None:
        return None
    kept, warnings = state.load_signing()
    for text in warnings:
        _complain(text)
    return Signing(clock.time_unix_ns, SigningState(*kept), lambda new: state.save_signing(new.key, new.horizon))


def _complain(text: str) -> None:
    print(f"companion: {text}", file=sys.stderr)


class _Stop:
    """Whether the run should end: Ctrl-C, SIGTERM, the duration."""

    def __init__(self, clock: WallClock, duration_s: float | None) -> None:
        self._clock, self._duration_s, self._asked = clock, duration_s, False
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._ask)

    def _ask(self, number: int, frame: object) -> None:
        self._asked = True

    def __call__(self) -> bool:
        return self._asked or (self._duration_s is not None and self._clock.now_s() >= self._duration_s)
