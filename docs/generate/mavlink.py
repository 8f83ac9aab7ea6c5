"""mavlink.md: modes by persona, messages in and out, commands, mission items."""

from __future__ import annotations

import ast
import importlib
import inspect
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import SimpleNamespace
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega, common

from companion.io.mavlink.commands.messages import MessageCommands
from companion.io.mavlink.commands.vessel import VesselCommands
from companion.io.mavlink.services.arming import ArmingService
from companion.io.mavlink.services.introduction import IntroductionService
from companion.io.mavlink.services.operator_control import OperatorService
from companion.io.mavlink.services.payload import PayloadService
from companion.io.mavlink.telemetry.following import NARROW
from companion.io.mavlink.telemetry.streams import NEVER, STREAMS
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import DO_SEND_BANNER, REQUEST_OPERATOR_CONTROL
from companion.mission.commands import RULES, Command, Range, Role
from docs.generate.markdown import anchored, code, number, page, section, sentence, summary, table
from docs.generate.modes import numbers_table
from docs.generate.source import Module, called, calls, modules
from docs.generate.templates import plain, templates

_COMMON = "https://mavlink.io/en/messages/common.html"
_WIRE = "companion/io/mavlink/"
_INTRODUCTION = """What a ground station, or your own program, can exchange with the boat. The boat speaks MAVLink
2 (`common.xml`, with newer messages
of `development.xml`). It has component id 1 and the system id in [`MAV_SYS_ID`](parameters.md#mav_sys_id)."""
_COMMANDS = """COMMAND_LONG and COMMAND_INT get one COMMAND_ACK at once.

| result | meaning |
| --- | --- |
| ACCEPTED | Done. |
| DENIED | Wrong at any time, or not allowed for this sender. |
| TEMPORARILY_REJECTED | Could be right at another time. |
| UNSUPPORTED | No such command here. |
| FAILED | Tried, without success. |

The reason of a refusal comes as STATUSTEXT. The same command again within 2 s counts as a repeated packet, if carrying
it out twice would make a difference."""
_SENT = """Default intervals for a fast line; on a slow one they grow. `?telemetry=leader` and
`?telemetry=high_latency` are options of a link.
SET_MESSAGE_INTERVAL and REQUEST_DATA_STREAM change them for one link."""
_ITEMS = """What a mission, a fence or a rally plan may hold. All else is refused, with the number of the item.
Items without effect are accepted, so that survey plans can be sailed."""
_ROLES: Mapping[Role, str] = {
    Role.NAVIGATION: "the boat does it until it is done",
    Role.CONDITION: "the boat does it between two navigation items",
    Role.DO: "at once, on the way",
    Role.GATE: "holds back the items at once after it, until it is met",
    Role.PAYLOAD: "at once, on the way: a camera or gimbal; without one it is told and does nothing",
    Role.IGNORED: "no effect",
    Role.ZONE: "part of a fence, or a rally point",
}


def mavlink_page() -> str:
    """The page."""
    headers = ("item", "number", "params", "what it is")
    items = [item for item in RULES.items() if item[1].role is not Role.IGNORED]
    ignored = ", ".join(code(Command(command).name) for command, rule in RULES.items() if rule.role is Role.IGNORED)
    return page(
        "MAVLink",
        _INTRODUCTION,
        section(2, "Mode numbers", numbers_table()),
        section(
            2,
            "Commands",
            _COMMANDS,
            *(_command(command, handler) for command, handler in sorted(command_handlers().items())),
        ),
        section(
            2,
            "Items of plans",
            _ITEMS,
            table(headers, (_item(command) for command, _ in items)),
            f"Without effect: {ignored}.",
        ),
        section(2, "Messages received", table(("message", "id", "handled by"), sorted(set(_received())))),
        section(
            2,
            "Messages sent",
            _SENT,
            table(("message", "id", "every", "on `leader`", "on `high_latency`"), _streamed()),
        ),
        section(2, "Messages in answer", table(("message", "id"), _answers())),
    )


_LACKING = {  # of pymavlink's `common`
    REQUEST_OPERATOR_CONTROL: "MAV_CMD_REQUEST_OPERATOR_CONTROL",
    DO_SEND_BANNER: "MAV_CMD_DO_SEND_BANNER",
}

# --- commands ------------------------------------------------------------------------------------------------------


def command_handlers() -> dict[int, Callable[..., Any]]:
    """Number of each command → the function that carries it out."""
    nothing: Any = SimpleNamespace(supervisor=SimpleNamespace())
    operators, arming = OperatorService(nothing, nothing), ArmingService(nothing, nothing, nothing, nothing)
    tables = (VesselCommands(nothing, nothing).commands, MessageCommands(nothing, nothing, nothing).commands)
    found: dict[int, Callable[..., Any]] = {
        REQUEST_OPERATOR_CONTROL: operators.carry_out,
        mavlink.MAV_CMD_RUN_PREARM_CHECKS: arming.run_checks,
        DO_SEND_BANNER: IntroductionService(nothing, nothing).banner,
        **PayloadService(nothing, nothing).commands,
    }
    for commands in tables:
        found |= commands
    return {number: _bare(handler) for number, handler in found.items()}


def _bare(handler: Callable[..., Any]) -> Callable[..., Any]:
    while isinstance(handler, partial):
        handler = handler.func
    return handler


def command_name(command: int) -> str:
    """`MAV_CMD_…` of a number."""
    names: Mapping[str, Any] = {**vars(ardupilotmega), **vars(common)}
    for name, value in names.items():
        if name.startswith("MAV_CMD_") and value == command:
            return name
    return _LACKING.get(command, f"command {command}")


class UndescribedCommand(Exception):
    """A command whose function has no docstring."""


def _command(command: int, handler: Callable[..., Any]) -> str:
    doc = inspect.getdoc(handler)
    if not doc:
        raise UndescribedCommand(f"{command_name(command)} ({command}): {handler.__qualname__} has no docstring")
    rows = [(f"param{n}", sentence(text)) for n, text in described_params(doc)]
    refused = "; ".join(f"“{text}”" for text in refusals(handler))
    return section(
        3,
        f"{command_name(command)} ({command})",
        sentence(summary(handler)),
        table(("param", "meaning"), rows),
        f"Refused: {refused}." if refused else "",
    )


def described_params(doc: str) -> list[tuple[int, str]]:
    """`param1: …` lines of a docstring, with the lines that go on."""
    found = re.findall(r"^param(\d): (.*(?:\n(?!param\d:|\n).+)*)", doc, re.MULTILINE)
    return [(int(digit), " ".join(text.split())) for digit, text in found]


def refusals(handler: Callable[..., Any]) -> list[str]:
    """The reasons that a command's own function gives; the supervisor has more."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(handler)))
    function = tree.body[0]
    assert isinstance(function, ast.FunctionDef)
    texts = [
        text
        for call in calls(function)
        if called(call) in ("denied", "not_now") and call.args
        for text in templates(call.args[0], function)
    ]
    return [plain(text) for text in dict.fromkeys(texts)]


# --- items of plans ------------------------------------------------------------------------------------------------


def _item(command: int) -> tuple[str, ...]:
    rule = RULES[command]
    params = [_param(allowed) for allowed in rule.ranges]
    if rule.position:
        params.append("5, 6: position")
    return anchored(Command(command).name), str(int(command)), "<br>".join(params), _ROLES[rule.role]


def _param(allowed: Range) -> str:
    return f"{allowed.number}: {allowed.label} ({allowed.remedy.removeprefix('give ')})"


# --- messages ------------------------------------------------------------------------------------------------------


def _wire() -> Iterator[Module]:
    """The modules that talk to ground stations."""
    return (module for module in modules("companion") if module.place.startswith(_WIRE))


def _received() -> Iterator[tuple[str, ...]]:
    for module in _wire():
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef):
                for key in _handled(node):
                    message = _number(key, module)
                    yield _named(message), str(message), f"{code(node.name)} in {code(module.place)}"


def _handled(node: ast.ClassDef) -> Iterator[ast.expr]:
    """Keys of the table `self.handles` of a service."""
    for inner in ast.walk(node):
        target = inner.target if isinstance(inner, ast.AnnAssign) else None
        if (
            isinstance(inner, ast.AnnAssign)
            and isinstance(target, ast.Attribute)
            and target.attr == "handles"
            and isinstance(inner.value, ast.Dict)
        ):
            yield from (key for key in inner.value.keys if key is not None)


def _number(key: ast.expr, module: Module) -> int:
    """The id that `mavlink.MAVLINK_MSG_ID_…`, or a constant of the module, stands for."""
    if isinstance(key, ast.Attribute):
        return int(getattr(mavlink, key.attr))
    assert isinstance(key, ast.Name), ast.unparse(key)
    return int(getattr(importlib.import_module(module.name), key.id))


def _named(message: int) -> str:
    """The name of a message, with a link to its definition where `common.xml` has it."""
    name = mavlink.MESSAGES[message].msgname
    return f"[`{name}`]({_COMMON}#{name})" if message in common.mavlink_map else code(name)


def _streamed() -> Iterator[tuple[str, ...]]:
    for message, stream in STREAMS.items():
        narrow = [_every(NARROW[kind].get(message, NEVER)) for kind in ("leader", "high_latency")]
        yield (_named(message), str(message), _every(stream.interval_s) or "when asked, or when it changes", *narrow)


def _every(interval_s: float) -> str:
    return "" if interval_s < 0.0 else f"{number(interval_s)} s"


def _answers() -> list[tuple[str, ...]]:
    """Messages that are made somewhere and never streamed."""
    names = {
        found[1]
        for module in _wire()
        for call in calls(module.tree)
        if (found := re.fullmatch(r"MAVLink_(\w+)_message", called(call)))
    }
    messages = {kind.msgname: identity for identity, kind in mavlink.MESSAGES.items()}
    return [
        (_named(messages[name.upper()]), str(messages[name.upper()]))
        for name in sorted(names)
        if messages[name.upper()] not in STREAMS
    ]
