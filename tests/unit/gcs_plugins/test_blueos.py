"""The BlueOS extension and Cockpit's extras by their shape; neither runs here."""

from __future__ import annotations

import json
import re
import threading
import urllib.error
import urllib.request
from http.server import ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from gcs_plugins.blueos import cockpit
from gcs_plugins.blueos.server import PORT, Handler
from gcs_plugins.commands import ACTIONS, MODES
from tests.waiting import CAP_S

DOCKERFILE = Path(cockpit.__file__).with_name("Dockerfile")
TAKEN_BY_BLUEOS = {
    2748,
    6020,
    6030,
    6040,
    7777,
    8000,
    8081,
    8088,
    9000,
    9002,
    9090,
    9100,
    9101,
    9110,
    9111,
    9120,
    9134,
    9150,
    9152,
    27353,
}


def labels() -> dict[str, str]:
    """LABEL lines, continued ones joined, quotes taken off, build arguments at their defaults."""
    text = DOCKERFILE.read_text(encoding="utf-8").replace("\\\n", "")
    defaults = dict(re.findall(r"^ARG (\w+)=(\S+)$", text, re.MULTILINE))
    found = {}
    for name, value in re.findall(r"^LABEL (\w+)=(.*)$", text, re.MULTILINE):
        plain = value[1:-1] if value[0] == "'" else value[1:-1].replace('\\"', '"')
        found[name] = re.sub(r"\$\{(\w+)\}", lambda m: defaults[m[1]], plain)
    return found


def test_the_image_has_the_labels_that_blueos_reads() -> None:
    found = labels()
    assert set(found) == {
        "version",
        "permissions",
        "authors",
        "company",
        "readme",
        "links",
        "type",
        "tags",
        "requirements",
    }
    assert re.fullmatch(r"\d+\.\d+\.\d+", found["version"])
    assert (
        found["type"] in ("device-integration", "example", "tool", "other") and found["requirements"] == "core >= 1.1"
    )
    assert (
        len(json.loads(found["tags"])) <= 10
        and json.loads(found["authors"])[0]["name"]
        and json.loads(found["company"])["name"]
    )
    host = json.loads(found["permissions"])["HostConfig"]
    assert host["NetworkMode"] == "host" and "/usr/blueos/extensions/usv-companion:/data" in host["Binds"]


def test_cockpits_extras_are_made_of_the_table() -> None:
    assert cockpit.EXTRAS.read_text(encoding="utf-8") == cockpit.text(), "python -m gcs_plugins.blueos write"
    extras = json.loads(cockpit.EXTRAS.read_text(encoding="utf-8"))
    assert (
        extras["targetSystem"] == "Cockpit" and extras["targetCockpitApiVersion"] == "1.0.0" and extras["widgets"] == []
    )
    offered = {action["id"]: action for action in extras["actions"]}
    assert len(offered) == len(extras["actions"]) == len([action for action in ACTIONS if action.at_once])
    for action in offered.values():
        assert action["type"] == "mavlink-message" and action["config"]["messageType"] == "COMMAND_LONG"
        message = {name: field["value"] for name, field in action["config"]["messageConfig"].items()}
        assert set(message) == set(mavlink.MAVLink_command_long_message.fieldnames)
        assert hasattr(mavlink, message["command"])
    (group,) = extras["joystickSuggestions"]
    for button in group["buttonMappingSuggestions"]:
        assert button["actionProtocol"] == "cockpit-action" and button["modifierKey"] in ("regular", "shift")
        assert offered[button["actionId"]]["name"] == button["actionName"] and 0 <= button["button"] <= 16


def test_modes_are_sent_as_a_link_of_ardupilots_persona_counts_them() -> None:
    by_id: dict[str, Any] = {action["id"]: action for action in cockpit.extras()["actions"]}
    hold = by_id["usv-companion-hold"]["config"]["messageConfig"]
    assert hold["command"]["value"] == "MAV_CMD_DO_SET_MODE" and hold["param2"]["value"] == MODES["Hold"].rover == 4


def test_cockpit_sends_at_once_and_so_gets_only_what_is_safe_so() -> None:
    ids = {action["id"].removeprefix("usv-companion-") for action in cockpit.extras()["actions"]}
    assert ids == {action.name for action in ACTIONS if action.at_once} and "arm" not in ids


def test_the_readme_names_the_buttons_that_are_suggested() -> None:
    readme = DOCKERFILE.with_name("README.md").read_text(encoding="utf-8").lower()
    for action in ACTIONS:
        if action.button is not None:
            assert action.label.lower() in readme, action.label


def test_the_server_answers_what_blueos_asks() -> None:
    assert PORT not in TAKEN_BY_BLUEOS
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        address = f"http://127.0.0.1:{server.server_port}"
        try:
            with urllib.request.urlopen(f"{address}/register_service", timeout=CAP_S) as answer:
                service = json.load(answer)
            with urllib.request.urlopen(address + service["extras"]["cockpit"], timeout=CAP_S) as answer:
                assert json.load(answer) == cockpit.extras()
            with pytest.raises(urllib.error.HTTPError) as refused:
                urllib.request.urlopen(f"{address}/etc/passwd", timeout=CAP_S)
            refused.value.close()
        finally:
            server.shutdown()
            thread.join()
