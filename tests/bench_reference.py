"""A fixed piece of Python, timed beside what `make bench` measures: times are told as multiples of it, so that commits
measured on other days and machines can be compared."""

from __future__ import annotations

import json
import math
import struct
import subprocess
import time
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from companion import native

ROOT = Path(__file__).parents[1]
SPEEDS = ROOT / "docs" / "results" / "speed" / "commits.json"
_ROUNDS = 5


def reference_s() -> float:
    """Processor time of the loop, the least of several."""
    return min(_timed() for _ in range(_ROUNDS))


def _timed() -> float:
    started_s = time.thread_time()
    _loop()
    return time.thread_time() - started_s


def _loop() -> float:
    """What a tick is made of: arithmetic of floats, tuples, dictionaries, bytes."""
    total, held = 0.0, {}
    for k in range(20_000):
        a, b = math.cos(0.001 * k), math.sin(0.001 * k)
        held[k % 64] = (a, b, a * b)
        total += held[(7 * k) % 64][0] if (7 * k) % 64 in held else 0.0
        if k % 8 == 0:
            total += struct.unpack("<fd", struct.pack("<fd", a, b))[1]
    return total


def kept() -> list[dict[str, Any]]:
    """What was measured of earlier commits, the oldest first."""
    if not SPEEDS.is_file():
        return []
    rows: list[dict[str, Any]] = json.loads(SPEEDS.read_text(encoding="utf-8"))["commits"]
    return rows


def measured_at(commit: str = "") -> dict[str, str]:
    """The commit, its time, today's date, and which arithmetic this process has. `commit`: left out, the work tree's."""
    return {
        "commit": commit or _git("rev-parse", "--short", "HEAD"),
        "committed": _git("show", "-s", "--format=%cI", commit or "HEAD"),
        "measured": datetime.now(UTC).date().isoformat(),
        "arithmetic": "compiled" if native.status.startswith("native") else "interpreted",
    }


def keep(speeds: Mapping[str, float], reference: float, commit: str = "") -> None:
    """Store the speeds of a commit, as work done in the time of the reference loop. Those of the same commit and
    arithmetic are replaced. `reference`: that time, s."""
    row = {
        **measured_at(commit),
        "reference_ms": round(1e3 * reference, 3),
        "speeds": {what: round(speed * reference, 5) for what, speed in speeds.items()},
    }
    rows = [*(other for other in kept() if not _same(other, row)), row]
    rows.sort(key=lambda one: datetime.fromisoformat(one["committed"]))
    SPEEDS.write_text(json.dumps({"commits": rows}, indent=1) + "\n", encoding="utf-8")


def newest() -> Mapping[str, Any] | None:
    """The newest kept commit of this process's arithmetic."""
    arithmetic = measured_at()["arithmetic"]
    return next((row for row in reversed(kept()) if row["arithmetic"] == arithmetic), None)


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return (one["commit"], one["arithmetic"]) == (other["commit"], other["arithmetic"])


def _git(*words: str) -> str:
    return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
