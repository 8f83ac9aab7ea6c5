"""A skiff of 2 m with one propeller and a rudder, as `companion new` writes it from what its owner knows."""

from __future__ import annotations

from companion.cli.new_file import Answers, file_text
from companion.config.vessel import parse

ANSWERS = Answers(
    "skiff", "Skiff", "monohull", 2.0, 0.6, 60.0, None, None, None, "rudder", "80", None, 0.0, "microcontroller", "two",
    63.442, 10.4,
)  # fmt: skip
TEXT = file_text(ANSWERS)
SKIFF = parse(TEXT, "skiff.toml")
