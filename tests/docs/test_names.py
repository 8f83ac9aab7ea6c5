"""Every parameter, message and command that a page names exists."""

from __future__ import annotations

import ast
import importlib
import re
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from companion.io.mavlink.commands.table import ROWS
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import REQUEST_OPERATOR_CONTROL
from companion.mission.commands import Command
from companion.params.table import TABLE
from docs.generate.mavlink import command_name
from tests.docs.pages import Block, blocks, label, prose, written

# Parameters of ArduPilot and PX4 boards that a bridge or a ground station needs, and other people's names.
_OTHERS = frozenset(
    {"FS_THR_ENABLE", "MAV_GCS_SYSID", "RC_FS_TIMEOUT", "RC_OVERRIDE_TIME", "SERVO_RC_FS_MSK"}
    | {"DO_SEND_BANNER", "SIM_RATE_HZ", "SMART_RTL", "SAIL_LOIT_RADIUS", "SAIL_WNDSPD_MIN", "SAIL_XTRACK_MAX"}
    # of ArduPilot
    | {"BRD_SAFETY_DEFLT", "MAV_LOG", "USV_CONSOLE_TOKEN", "USV_LINK", "USV_NATIVE", "USV_SAFE_CUT", "USV_SAFE_STICKS"}
)
_NAME = re.compile(r"(?<![\w./-])[A-Z][A-Z0-9]*(?:_[A-Z0-9]+)+(?![\w*])")
_TYPED = re.compile(
    r"`(?:companion|usvctl|usv|module|--|[a-z_]+=)[^`]*`"
)  # in it capitals stand for what people fill in
_COMMAND = re.compile(r"MAV_CMD_[A-Z0-9_]*[A-Z0-9]")


def _known() -> frozenset[str]:
    parameters = {spec.name for spec in TABLE}
    wire = {kind.msgname for kind in mavlink.MESSAGES.values()} | {name for name in vars(common) if name.isupper()}
    commands = {name.removeprefix("MAV_CMD_") for name in wire if name.startswith("MAV_CMD_")}
    carried_out = {command_name(row.number) for row in ROWS} | {command_name(REQUEST_OPERATOR_CONTROL)}
    own = carried_out | {command.name for command in Command}
    return frozenset(parameters | wire | commands | own | _OTHERS)


KNOWN = _known()


@pytest.mark.parametrize("path", written(), ids=label)
def test_every_name_exists(path: Path) -> None:
    unknown = sorted(set(_NAME.findall(_TYPED.sub("", prose(path)))) - KNOWN)
    assert not unknown, (
        f"{label(path)}: {', '.join(unknown)}: no parameter, message or command; if right, add to _OTHERS"
    )


@pytest.mark.parametrize("path", written(), ids=label)
def test_every_mavlink_command_exists(path: Path) -> None:
    unknown = sorted(set(_COMMAND.findall(path.read_text(encoding="utf-8"))) - KNOWN)
    assert not unknown, f"{label(path)}: {', '.join(unknown)}"


@pytest.mark.parametrize("block", list(blocks("python")), ids=lambda block: block.place)
def test_every_python_block_compiles_and_imports_what_there_is(block: Block) -> None:
    tree = ast.parse(block.text, block.place)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and str(node.module).split(".")[0] in ("companion", "gcs_plugins", "sitl"):
            module = importlib.import_module(str(node.module))
            missing = [alias.name for alias in node.names if not hasattr(module, alias.name)]
            assert not missing, f"{block.place}: {node.module} has no {', '.join(missing)}"
