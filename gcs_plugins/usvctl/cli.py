"""The commands of `usvctl`. Exit codes: 0 done, 1 refused with the boat's reason, or not ready, 2 a mistake in the
command, or no boat."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.mission import files as mission_files
from companion.mission.plan_file import PlanFileError
from gcs_plugins.commands import ACTIONS, BY_NAME, MODES, MavCmd

if TYPE_CHECKING:
    from gcs_plugins.usvctl.boat import Boat

LINK = "udpin://0.0.0.0:14550"
_PLAIN = ("hold", "pause", "continue", "return", "arm", "disarm", "stop", "lower", "retract")
_FOREVER_S = 1e6

Command = Callable[["Boat", argparse.Namespace], int | None]


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command. Returns its exit code."""
    arguments = argument_parser().parse_args(argv)
    try:
        from gcs_plugins.usvctl.boat import Mistake, NoVessel, Refused, connected
    except ModuleNotFoundError as error:
        print(f"usvctl: needs {error.name}: pip install 'usv-companion[usvctl]'", file=sys.stderr)
        return 2
    try:
        prepare = getattr(arguments, "prepare", None)
        if prepare is not None:  # mistakes in files are reported without a boat
            prepare(arguments)
        _ask(arguments)
        with connected(arguments.link, arguments.timeout) as boat:
            return int(arguments.command(boat, arguments) or 0)
    except Refused as refusal:
        print(f"refused: {refusal}", file=sys.stderr)
        return 1
    except (Mistake, NoVessel) as error:
        print(f"usvctl: {error}", file=sys.stderr)
        return 2
    except PlanFileError as error:
        print("\n".join(error.problems), file=sys.stderr)
        return 2
    except OSError as error:
        print(f"usvctl: {error.filename}: {error.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _ask(arguments: argparse.Namespace) -> None:
    """At a terminal, ask before an action that is not safe at once; a script is not asked. Raises Mistake without a
    yes."""
    from gcs_plugins.usvctl.boat import Mistake

    action = BY_NAME.get(getattr(arguments, "action", ""))
    if action is None or action.at_once or arguments.yes or not sys.stdin.isatty():
        return
    print(f"{action.label}: {action.asks}. Send it? [y/N] ", end="", flush=True)
    if sys.stdin.readline().strip().lower() not in ("y", "yes"):
        raise Mistake("not sent")


# --- commands ------------------------------------------------------------------------------------------------------


def _do(boat: Boat, arguments: argparse.Namespace) -> None:
    boat.do(arguments.action)


def _checks(boat: Boat, arguments: argparse.Namespace) -> None:
    heard = boat.texts_heard
    boat.do("checks")
    print(boat.reason(heard).replace("; ", "\n") or "nothing prevents arming")


def _upload(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import plans

    plans.upload(boat, arguments.plan)
    plan = arguments.plan
    print(f"uploaded: {len(plan.mission)} items, fence {len(plan.fence)}, rally points {len(plan.rally)}")


def _read_plan(arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import plans

    arguments.plan = plans.read(arguments.file)


def _download(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import plans

    plan = plans.download(boat)
    arguments.file.write_text(mission_files.write(arguments.file.name, plan), encoding="utf-8")
    print(f"{arguments.file}: {len(plan.mission)} items, fence {len(plan.fence)}, rally points {len(plan.rally)}")


def _start(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import live

    if arguments.item is not None:
        boat.command(MavCmd.DO_SET_MISSION_CURRENT, float(arguments.item - (not boat.rover_numbers)), 1.0)
    boat.do("start")
    _arm(boat, arguments)
    if arguments.wait:
        live.sail(boat, arguments.within)


def _go_to(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import live

    boat.go_to(arguments.lat, arguments.lon, arguments.heading, arguments.speed)
    if arguments.wait:
        live.arrive(boat, arguments.lat, arguments.lon, arguments.radius, arguments.within)


def _follow(boat: Boat, arguments: argparse.Namespace) -> None:
    if arguments.station is not None:
        boat.command(MavCmd.USER_3, *arguments.station)
    boat.command(MavCmd.DO_FOLLOW, float(arguments.leader))


def _arm(boat: Boat, arguments: argparse.Namespace) -> None:
    if arguments.arm:
        boat.do("arm")


def _dock(boat: Boat, arguments: argparse.Namespace) -> None:
    boat.do("dock")
    _arm(boat, arguments)


def _get(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import parameters
    from gcs_plugins.usvctl.boat import Mistake

    values = parameters.read_all(boat)
    unknown = [name for name in arguments.names if name not in values]
    if unknown:
        raise Mistake(f"no such parameter: {', '.join(unknown)}")
    for name in arguments.names or values:
        print(f"{name} {values[name]:.7g}")


def _set(boat: Boat, arguments: argparse.Namespace) -> None:
    _write_parameters(boat, {arguments.name: arguments.value})


def _load(boat: Boat, arguments: argparse.Namespace) -> None:
    _write_parameters(boat, arguments.values)


def _read_values(arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import parameters

    arguments.values = parameters.from_file(arguments.file)


def _write_parameters(boat: Boat, wanted: dict[str, float]) -> None:
    """Write those that differ. All are tried; one refusal gives the reasons of all that failed."""
    from gcs_plugins.usvctl import parameters
    from gcs_plugins.usvctl.boat import Refused

    present, refusals, changed = parameters.read_all(boat), [], 0
    for name, value in wanted.items():
        if name in present and math.isclose(present[name], value, rel_tol=1e-6):
            continue
        try:
            parameters.write(boat, name, value, whole=isinstance(present.get(name), int))
            changed += 1
        except Refused as refusal:
            refusals.append(str(refusal))
    print(f"{changed} of {len(wanted)} changed")
    if refusals:
        raise Refused("; ".join(refusals))


def _save(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import parameters

    values = parameters.read_all(boat)
    arguments.file.write_text(parameters.to_text(values, boat.system_id), encoding="utf-8")
    print(f"{arguments.file}: {len(values)} parameters")


def _logs_list(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import files

    for entry in files.logs(boat):
        print(f"{entry.id:4} {entry.date} {entry.size_bytes:12}")


def _logs_get(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import files

    print(files.get_log(boat, arguments.log, arguments.dir))


def _files_list(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import files

    print("\n".join(files.listing(boat, arguments.path)))


def _files_get(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import files

    print(files.get_file(boat, arguments.path, arguments.dir))


def _status(boat: Boat, arguments: argparse.Namespace) -> int:
    from gcs_plugins.usvctl import status

    return 0 if status.show(boat) else 1


def _watch(boat: Boat, arguments: argparse.Namespace) -> None:
    from gcs_plugins.usvctl import live

    live.watch(boat, arguments.seconds)


# --- what can be asked ---------------------------------------------------------------------------------------------


def argument_parser() -> argparse.ArgumentParser:
    """What can be asked on the command line."""
    parser = argparse.ArgumentParser(
        prog="usvctl",
        description="Command the boat from a shell.",
        epilog="Exit codes: 0 done, 1 refused by the boat or not ready, 2 a mistake, or no boat. "
        "While usvctl runs it is a ground station of the boat. If it is the only one, the boat loses it "
        "when usvctl ends (NAV_DLL_ACT).",
    )
    parser.add_argument(
        "--link", default=LINK, help="MAVSDK connection URL, udpin://…, tcpout://HOST:PORT, serial://… (%(default)s)"
    )
    parser.add_argument(
        "--timeout", type=_positive, default=10.0, metavar="S", help="how long to look for a boat (%(default)g)"
    )
    _add_yes(parser, False)
    verbs = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_steering(verbs)
    _add_missions(verbs)
    _add_parameters(verbs)
    _add_files(verbs)
    _add(verbs, "status", "mode, fix, battery, links, failsafes; exit code 0 when the boat is ready, else 1", _status)
    watch = _add(verbs, "watch", "show the boat's state, until Ctrl-C", _watch)
    watch.add_argument("--seconds", type=_positive, default=_FOREVER_S, metavar="S")
    return parser


def _add_steering(verbs: Any) -> None:
    for name in _PLAIN:
        _add(verbs, name, BY_NAME[name].text, _do).set_defaults(action=name)
    _add(verbs, "checks", BY_NAME["checks"].text, _checks)
    do = _add(verbs, "do", "any action of the table by its name", _do)
    do.add_argument("action", choices=[action.name for action in ACTIONS], metavar="NAME", help=", ".join(BY_NAME))
    mode = _add(verbs, "mode", "another mode", lambda boat, arguments: boat.set_mode(arguments.name))
    mode.add_argument("name", choices=list(MODES))
    go_to = _add(verbs, "goto", "go there and hold", _go_to)
    go_to.add_argument("lat", type=_within(90.0), metavar="LAT")
    go_to.add_argument("lon", type=_within(180.0), metavar="LON")
    go_to.add_argument("--heading", type=_within(360.0), default=math.nan, metavar="DEG")
    go_to.add_argument("--speed", type=_positive, default=math.nan, metavar="MPS")
    go_to.add_argument(
        "--radius", type=_positive, default=1.0, metavar="M", help="with --wait: near enough (%(default)g)"
    )
    _add_wait(go_to, "until it is there")
    dock = _add(verbs, "dock", BY_NAME["dock"].text, _dock)
    dock.set_defaults(action="dock")
    dock.add_argument("--arm", action="store_true")
    nudge = _add(
        verbs,
        "nudge",
        "move the hold point and the heading",
        lambda boat, a: boat.command(MavCmd.USER_1, 1.0, a.ahead, a.starboard, a.turn),
    )
    for name, default in (("ahead", None), ("starboard", None), ("turn", 0.0)):
        nudge.add_argument(
            name,
            type=_finite,
            nargs=None if default is None else "?",
            default=default,
            metavar="DEG" if name == "turn" else name.upper(),
        )
    turn = _add(
        verbs,
        "turn",
        "another heading at the hold point",
        lambda boat, a: boat.command(MavCmd.USER_1, 2.0, a.heading % 360.0),
    )
    turn.add_argument("heading", type=_within(360.0), metavar="DEG")
    follow = _add(verbs, "follow", "follow a lead boat", _follow)
    follow.set_defaults(action="follow")
    follow.add_argument("--leader", type=int, default=-1, metavar="SYSID", help="its system id; else FOLL_SYSID")
    follow.add_argument(
        "--station", type=_station, metavar="BEARING@M", help="as 180@20: 20 m astern; 90 is to its starboard"
    )
    station = _add(
        verbs,
        "station",
        "the follow position on the lead boat",
        lambda boat, a: boat.command(MavCmd.USER_3, *a.station),
    )
    station.add_argument("station", type=_station, metavar="BEARING@M")


def _add_missions(verbs: Any) -> None:
    known = ", ".join(mission_files.FORMATS)
    upload = _add(verbs, "upload", f"a plan file becomes the boat's plan ({known})", _upload)
    upload.add_argument("file", type=Path, metavar="FILE")
    upload.set_defaults(prepare=_read_plan)
    download = _add(verbs, "download", "the boat's plan into a file of the suffix's format", _download)
    download.add_argument("file", type=Path, metavar="FILE")
    start = _add(verbs, "start", BY_NAME["start"].text, _start)
    start.set_defaults(action="start")
    start.add_argument("--arm", action="store_true", help="and arm")
    start.add_argument("--item", type=_item_number, metavar="N", help="from this item; the first is 1")
    _add_wait(start, "until it is done")


def _add_parameters(verbs: Any) -> None:
    params = verbs.add_parser("params", help="read and write parameters").add_subparsers(
        required=True, metavar="get | set | save | load"
    )
    _add(params, "get", "print some, or all", _get).add_argument("names", nargs="*", metavar="NAME")
    set_ = _add(params, "set", "change one", _set)
    set_.add_argument("name", metavar="NAME")
    set_.add_argument("value", type=_finite, metavar="VALUE")
    _add(params, "save", "all into a .params file", _save).add_argument("file", type=Path, metavar="FILE")
    load = _add(params, "load", "those of a file that differ", _load)
    load.add_argument("file", type=Path, metavar="FILE")
    load.set_defaults(prepare=_read_values)


def _add_files(verbs: Any) -> None:
    logs = verbs.add_parser("logs", help="list and fetch logs").add_subparsers(required=True, metavar="list | get")
    _add(logs, "list", "number, date, bytes", _logs_list)
    get = _add(logs, "get", "fetch one", _logs_get)
    get.add_argument("log", type=int, nargs="?", metavar="N", help="its number; else the newest")
    get.add_argument("--dir", type=Path, default=Path(), metavar="DIR")
    files = verbs.add_parser("files", help="list and fetch the boat's files over MAVLink FTP").add_subparsers(
        required=True, metavar="list | get"
    )
    _add(files, "list", "a folder", _files_list).add_argument("path", nargs="?", default="/", metavar="PATH")
    get = _add(files, "get", "fetch a file", _files_get)
    get.add_argument("path", metavar="PATH")
    get.add_argument("--dir", type=Path, default=Path(), metavar="DIR")


def _add(verbs: Any, name: str, text: str, command: Command) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = verbs.add_parser(name, help=text)
    parser.set_defaults(command=command)
    _add_yes(parser, argparse.SUPPRESS)  # which would undo one before the command
    return parser


def _add_yes(parser: argparse.ArgumentParser, default: Any) -> None:
    parser.add_argument("--yes", action="store_true", default=default, help="ask nothing, also at a terminal")


def _add_wait(parser: argparse.ArgumentParser, text: str) -> None:
    parser.add_argument("--wait", action="store_true", help=f"wait {text}; exit code 1 when the boat stops trying")
    parser.add_argument(
        "--within",
        type=_positive,
        default=_FOREVER_S,
        metavar="S",
        help="with --wait: exit code 1 when it takes longer",
    )


def _item_number(word: str) -> int:
    number = int(word)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{word}: the first item is 1")
    return number


def _finite(word: str) -> float:
    value = float(word)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{word} is no number")
    return value


def _positive(word: str) -> float:
    value = _finite(word)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{word} should be above 0")
    return value


def _within(most: float) -> Callable[[str], float]:
    def degrees(word: str) -> float:
        value = _finite(word)
        if abs(value) > most:
            raise argparse.ArgumentTypeError(f"{word} is not within {most:g} degrees")
        return value

    return degrees


def _station(word: str) -> tuple[float, float]:
    bearing, at, distance = word.partition("@")
    if not at:
        raise argparse.ArgumentTypeError(f"{word}: give BEARING@M, as 180@20")
    return _within(360.0)(bearing), _positive(distance)
