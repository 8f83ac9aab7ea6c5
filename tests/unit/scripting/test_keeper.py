"""Scripts in their own processes that do what scripts should not: the keeper outlives all of it."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from companion.core.decision import TextKind
from companion.io.mavlink.wire.script_link import ScriptLink
from companion.record.feed import Feed
from companion.scripting.keeper import KeptScript, ScriptKeeper
from companion.scripting.keeping import Keeping, Restart
from companion.scripting.limits import write_only_below
from companion.scripting.runner import Settings, settings_of
from tests.unit.record.ticks import tick
from tests.waiting import wait_until

pytestmark = pytest.mark.process


class Kept:
    """A keeper of one script, and a feed that ticks while somebody waits."""

    def __init__(
        self,
        folder: Path,
        text: str,
        watchdog_s: float = 0.0,
        memory_mb: int = 256,
        restart: Restart = "never",
        disk_mb: int = 64,
    ) -> None:
        folder.mkdir(exist_ok=True)
        (folder / "script.py").write_text(text, encoding="utf-8")
        self.folder, self.texts, self.enabled = folder, [], True
        self.feed = Feed(
            folder / "feed.sock", {"system": 1, "modes": []}, ("port", "bow"), ("gnss", "imu"), lambda now_s: {}, 0.01
        )
        self.link = ScriptLink("bad", 231, ())
        settings = Settings(
            str(folder / "script.py"),
            ("a", "b"),
            231,
            str(folder / "feed.sock"),
            str(folder),
            0,
            -1,
            memory_mb=memory_mb,
            disk_mb=disk_mb,
        )
        self.script = KeptScript(
            "bad", Keeping("bad", restart, watchdog_s, 1.0), settings, folder / "out.log", self.link.theirs.fileno()
        )
        self.keeper = ScriptKeeper([self.script], self._say, lambda: self.enabled)
        self.ticks = 0

    def _say(self, now_s: float, kind: TextKind, name: str, text: str) -> None:
        assert name == "script_bad"
        self.texts.append(text)

    def look(self) -> None:
        self.ticks += 1
        self.feed.record(tick(0.1 * self.ticks))
        self.keeper.announce(0.0)

    def until(self, text: str) -> None:
        wait_until(lambda: self.look() or any(text in one for one in self.texts), f"{text}: {self.texts}")

    def close(self) -> None:
        self.keeper.close()
        self.feed.close()
        self.link.close()

    @property
    def output(self) -> str:
        return (self.folder / "out.log").read_text(encoding="utf-8")


def test_a_script_sees_the_boat_and_speaks(tmp_path: Path) -> None:
    kept = Kept(
        tmp_path / "s",
        "def main(boat):\n"
        "    state = boat.next_state()\n"
        "    print(state.mode, boat.arguments)\n"
        "    boat.say('all is well')\n"
        "    open('own', 'w').write('mine')\n",
    )
    kept.until("bad: all is well")
    kept.until("Script bad has ended")
    assert kept.output.strip().endswith("Hold ('a', 'b')") and (tmp_path / "s" / "own").read_text() == "mine"
    kept.close()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("def main(boat):\n    raise ValueError('too deep')\n", "failed: line 2: ValueError: too deep"),
        ("def main(boat):\n    hoard = [bytearray(10**8) for _ in range(100)]\n", "failed: out of memory (memory_mb)"),
        ("import os\ndef main(boat):\n    os.kill(os.getpid(), 11)\n", "failed: ended by signal 11"),
        ("import os\ndef main(boat):\n    os._exit(7)\n", "failed: exit code 7"),
        ("def main(boat):\n    open('big', 'wb').write(bytes(65 * 10**6))\n", "OSError: [Errno 27] File too large"),
        ("def main(boat):\n    [open('/dev/null') for _ in range(1000)]\n", "Too many open files"),
        ("def main(boat):\n    raise ValueError('too deep\\nby far')\n", "failed: line 2: ValueError: too deep"),
    ],
    ids=["raises", "hoards", "crashes", "exits", "fills the disk", "descriptors", "raises several lines"],
)
def test_its_failure_is_told(tmp_path: Path, text: str, reason: str) -> None:
    kept = Kept(tmp_path / "s", text)
    kept.until(reason)
    assert not any("\n" in one for one in kept.texts)
    kept.close()


def test_a_script_outlives_the_log_that_it_has_filled(tmp_path: Path) -> None:
    kept = Kept(
        tmp_path / "s",
        "def main(boat):\n"
        "    for _ in range(1100): print('x' * 1000)\n"
        "    boat.say('still here')\n"
        "    boat.next_state()\n"
        "    raise ValueError('too deep')\n",
        disk_mb=1,
    )
    kept.until("bad: still here")
    kept.until("failed: line 5: ValueError: too deep")
    assert (tmp_path / "s" / "out.log").stat().st_size == 1_000_000
    kept.close()


def test_a_hung_script_is_killed_with_all_that_it_has_started(tmp_path: Path) -> None:
    kept = Kept(
        tmp_path / "s",
        "import os, signal\n"
        "def main(boat):\n"
        "    signal.signal(signal.SIGTERM, signal.SIG_IGN)\n"
        "    if os.fork() == 0:\n"
        "        open('child', 'w').write(str(os.getpid()))\n"
        "    while True: pass\n",
        watchdog_s=1.5,
        restart="failure",  # on a loaded machine one may be killed before it has a child
    )
    wait_until(lambda: kept.look() or (tmp_path / "s" / "child").exists(), "the script's own child")
    kept.until("failed: hung")
    child = int(wait_until(lambda: (tmp_path / "s" / "child").read_text(), "its number"))
    wait_until(lambda: not _alive(child), "the child's end")
    kept.close()


def _alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_it_ends_with_the_switch_and_with_its_keeper(tmp_path: Path) -> None:
    kept = Kept(tmp_path / "s", "def main(boat):\n    for state in boat.states(): pass\n")
    kept.until("started")
    kept.enabled = False
    kept.until("ended: SCR_ENABLE is 0")
    kept.enabled = True
    wait_until(lambda: kept.look() or kept.texts.count("Script bad started") == 2, "a second start")
    process = kept.script.process
    assert process is not None
    kept.close()
    assert not _alive(process.pid)


def test_it_writes_below_its_own_folder_only(tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.write_text("theirs")
    kept = Kept(tmp_path / "s", f"def main(boat):\n    open({str(other)!r}, 'w')\n")
    if _has_landlock(tmp_path):
        kept.until("PermissionError")
        assert other.read_text() == "theirs"
    else:
        kept.until("has ended")
        assert "no Landlock" in kept.output
    kept.close()


def _has_landlock(folder: Path) -> bool:
    """Asked in a process of its own, since what is given up does not come back."""
    child = os.fork()
    if child == 0:
        os._exit(0 if write_only_below(folder) else 1)
    return os.waitpid(child, 0)[1] == 0


def test_what_it_does_not_read_holds_nobody_up(tmp_path: Path) -> None:
    """The boat writes to a script that reads nothing, and a flood of texts becomes one a second."""
    kept = Kept(
        tmp_path / "s", "def main(boat):\n    for n in range(100000): boat.say('x' * 3000)\n    boat.sleep(60)\n"
    )
    kept.until("bad: xxx")
    link = kept.link
    link.fault = None
    (endpoint,) = link.endpoints
    for _ in range(200):
        endpoint.send_bytes(bytes(30000))
        endpoint.flush(0.0)
    assert max(map(len, kept.texts)) < 120 and sum("xxx" in text for text in kept.texts) < 20
    kept.close()


def test_its_words_can_always_be_logged(tmp_path: Path) -> None:
    """Python has the name of a file that is no UTF-8 with code points that no encoding takes."""
    name = "os.fsdecode(b'\\xc5lesund.jpg')"
    kept = Kept(
        tmp_path / "s", f"import os\ndef main(boat):\n    boat.say({name})\n    raise KeyError(os.fsdecode(b'\\xc5'))\n"
    )
    kept.until(r"bad: \udcc5lesund.jpg")
    kept.until("failed: line 4: KeyError")
    kept.close()
    assert all(text.encode() for text in (*kept.texts, kept.script.keeping.fault or ""))


def test_what_is_no_word_of_the_interface_is_left_out(tmp_path: Path) -> None:
    text = "import os\ndef main(boat):\n    [write(fd) for fd in range(3, 200)]\n    boat.say('still here')\n"
    write = "def write(fd):\n    try:\n        os.write(fd, b'[' * 60000 + b'\\n')\n    except OSError:\n        pass\n"
    kept = Kept(tmp_path / "s", text + write)
    kept.until("bad: still here")
    kept.close()


def test_a_script_for_which_no_descriptor_is_left_has_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(flags: int) -> tuple[int, int]:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    settings = Settings(str(tmp_path / "script.py"), (), 231, str(tmp_path / "feed.sock"), str(tmp_path), 0, -1)
    script = KeptScript("late", Keeping("late", "failure", 0.0, 1.0), settings)
    keeper = ScriptKeeper([], lambda *said: None, lambda: True)
    monkeypatch.setattr(os, "pipe2", refused)
    keeper.look_after(script)
    keeper.close()
    assert script.keeping.fault == "not started: Too many open files" and not script.keeping.over


def test_settings_go_over_a_command_line() -> None:
    settings = Settings("a.py", ("x y", "ü"), 231, "f", "g", 1, 2, address=("127.0.0.1", 5760))
    assert settings_of(settings.text()) == settings
