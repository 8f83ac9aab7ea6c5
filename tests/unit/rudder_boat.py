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


def beside(text: str, **side_n: tuple[float, float]) -> str:
    """The file with more fixed thrusters that push to starboard: name=(place ahead in m, thrust in N)."""
    rows = "".join(
        f'[[thruster]]\nname = "{name}"\nkind = "fixed"\nx_m = {x_m}\ny_m = 0\nazimuth_deg = 90\nmax_n = {most_n}\n\n'
        for name, (x_m, most_n) in side_n.items()
    )
    names = "".join(f', "{name}"' for name in side_n)
    head, bridge = text.replace("[[sensor]]", rows + "[[sensor]]", 1).rsplit("]", 1)
    return f"{head}{names}]{bridge}"


SHIP_TEXT = beside(TEXT, bow=(0.8, 15.0), stern=(-0.7, 15.0))
"""The skiff with thrusters across bow and stern."""
