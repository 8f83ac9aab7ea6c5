"""The Arduino sketch, as far as a host compiler can judge it; and the core by the plainest of C99."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.unit.io.actuators.firmware.host import CORE, HERE, STRICT, compiler
from tests.waiting import CAP_S

SOURCES = sorted(CORE.glob("usv_*.[ch]"))


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler on this machine")
@pytest.mark.parametrize(
    ("receiver", "port", "compiles"),
    [
        ("USV_RC_PPM", "", True),
        ("USV_RC_NONE", "", True),
        ("USV_RC_SBUS", "Serial1", True),
        ("USV_RC_CRSF", "Serial1", True),
        ("USV_RC_CRSF", "", False),
    ],
)
def test_the_sketch_compiles_against_arduinos_interface(
    receiver: str, port: str, compiles: bool, tmp_path: Path
) -> None:
    sketch = Path(shutil.copytree(CORE, tmp_path / "usv_board"))
    config = sketch / "board_config.h"
    text = config.read_text(encoding="utf-8").replace("RC_PROTOCOL USV_RC_PPM", f"RC_PROTOCOL {receiver}")
    config.write_text(text.replace("/* #define RC_PORT Serial1 */", f"#define RC_PORT {port}" if port else ""))
    flags = [
        "-std=gnu++11",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-fsyntax-only",
        "-x",
        "c++",
        "-include",
        "Arduino.h",
        f"-I{HERE / 'arduino'}",
    ]
    command = ["c++", *flags, str(sketch / "usv_board.ino")]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=CAP_S)
    assert (done.returncode == 0) is compiles, done.stderr
    assert compiles or "need an RC_PORT in board_config.h" in done.stderr


@pytest.mark.parametrize("source", [path for path in SOURCES if path.suffix == ".c"], ids=lambda path: path.name)
def test_the_core_compiles_freestanding_and_without_a_warning(source: Path, tmp_path: Path) -> None:
    flags = [*STRICT, "-Wshadow", "-Wvla", "-O2", "-ffreestanding", "-c"]
    subprocess.run([compiler(), *flags, str(source), "-o", str(tmp_path / "core.o")], check=True, timeout=CAP_S)


def test_the_core_knows_no_platform() -> None:
    """Nothing but freestanding headers and string.h for copying; no allocation, no floating point."""
    text = "\n".join(path.read_text(encoding="utf-8") for path in SOURCES)
    assert set(re.findall(r"#include <(\S+)>", text)) == {"stdbool.h", "stddef.h", "stdint.h", "string.h"}
    code = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    assert not re.search(r"\b(malloc|calloc|free|alloca|float|double|while \((1|true)\))\b", code)
