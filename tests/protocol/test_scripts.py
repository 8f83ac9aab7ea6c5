"""Scripts beside a running companion: those of the vessel's file, and one by hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.config.vessel import find
from tests.copies import run_to_end
from tests.protocol.process import Companion
from tests.waiting import wait_until

pytestmark = pytest.mark.process

READER = """
from companion.scripting import ScriptError

def main(boat):
    for ask in (boat.arm, boat.hold, lambda: boat.set_parameter("WP_SPEED", 1.1), lambda: boat.upload([])):
        try:
            ask()
            print("obeyed")
        except ScriptError as error:
            print(error)
    print(boat.parameter("WP_SPEED"), boat.state.mode)
    boat.say("reader is done")
    boat.sleep(3600)
"""
SAILOR = """
def main(boat):
    boat.wait_until(lambda state: state.row["position_valid"])
    boat.set_parameter("WP_SPEED", 0.7)
    boat.set_mode("Hold")
    boat.say("sailor is done")
"""
ROWS = """
[[script]]
name = "reader"
file = "reader.py"
[[script]]
name = "sailor"
file = "sailor.py"
may = ["command", "parameter"]
"""


def test_scripts_of_the_vessel_file_do_what_they_may(tmp_path: Path) -> None:
    vessel = tmp_path / "revolt.toml"
    vessel.write_text(find("revolt").read_text(encoding="utf-8") + ROWS, encoding="utf-8")
    (tmp_path / "reader.py").write_text(READER, encoding="utf-8")
    (tmp_path / "sailor.py").write_text(SAILOR, encoding="utf-8")
    with Companion(tmp_path, vessel=vessel, extra=("--sitl",)) as boat:

        def heard(text: str) -> bool:
            return any(text in row["text"] for row in boat.rows("events.csv"))

        wait_until(lambda: heard("reader is done") and heard("sailor is done"), "both scripts")
        said = (boat.log_folder / "script-reader.log").read_text(encoding="utf-8")
        assert said.startswith("command 400: ") and "Not obeyed: this script may not do that" in said, "once in 30 s"
        assert "obeyed\n" not in said and len(said.splitlines()) == 5
        assert wait_until(lambda: boat.rows()[-1]["mode"] == "Hold", "Hold, as the sailor asked")
        by_hand = tmp_path / "by_hand.py"
        by_hand.write_text("def main(boat):\n    print(boat.parameter('WP_SPEED'), boat.arguments)\n", encoding="utf-8")
        ran = run_to_end("script", str(by_hand), "x", "--state", str(tmp_path / "state"))
        assert ran.returncode == 0 and "0.7" in ran.stdout and "('x',)" in ran.stdout and "has ended" in ran.stdout


def test_a_script_that_cannot_be_run_is_told_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "a.py"
    file.write_text("def main(boat): pass\n", encoding="utf-8")
    for words, reason in (
        ((str(tmp_path / "no.py"),), "no such file"),
        ((str(file), "--state", str(tmp_path)), "no companion runs"),
        ((str(file), "--system-id", "0"), "1 to 255"),
    ):
        ran = run_to_end("script", *words)
        assert ran.returncode == 2 and reason in ran.stderr and ran.stderr.count("\n") == 1
