"""[[camera]] in a vessel's file: what each kind needs, and every fault with its place."""

from __future__ import annotations

import pytest

from companion.config.vessel import ConfigError, find, parse

OUTPUTS = """
[[relay]]
name = "shutter"
while_disarmed = true
[[servo]]
name = "finger"
rest_us = 1100.0
[[servo]]
name = "limp"
"""


def parsed(cameras: str) -> tuple[str, ...]:
    """The problems of a ReVolt with these cameras; empty for none."""
    text = find("revolt").read_text(encoding="utf-8")
    bridge = 'thrusters = ["stern_port", "stern_starboard", "bow"]'
    text = text.replace(bridge, f'{bridge}\nrelays = ["shutter"]\nservos = ["finger", "limp"]', 1)
    try:
        config = parse(text + OUTPUTS + cameras, "boat.toml")
    except ConfigError as error:
        return error.problems
    assert config.cameras
    return ()


GOOD = [
    '[[camera]]\nname = "below"\nkind = "relay"\nrelay = "shutter"\npulse_s = 0.3\ninterval_s = 0.8\nz_m = 0.4\n',
    '[[camera]]\nname = "ahead"\nkind = "servo"\nservo = "finger"\npress_us = 1900.0\n',
    '[[camera]]\nname = "linked"\nkind = "mavlink"\ncomponent = 100\n',
]


@pytest.mark.parametrize("camera", [*GOOD, "".join(GOOD)])
def test_each_kind(camera: str) -> None:
    assert parsed(camera) == ()


@pytest.mark.parametrize(
    ("camera", "problem"),
    [
        ('name = "a"\nkind = "gopro"', "camera[1].kind"),
        ('name = "a"\nkind = "relay"', "kind 'relay' needs relay"),
        ('name = "a"\nkind = "relay"\nrelay = "lamp"', "no relay named 'lamp'"),
        ('name = "a"\nkind = "relay"\nrelay = "shutter"\ncomponent = 100', "only for kind 'mavlink', not 'relay'"),
        ('name = "a"\nkind = "servo"\nservo = "finger"', "kind 'servo' needs press_us"),
        ('name = "a"\nkind = "servo"\nservo = "thumb"\npress_us = 1900.0', "no servo named 'thumb'"),
        ('name = "a"\nkind = "servo"\nservo = "limp"\npress_us = 1900.0', "'limp' needs rest_us"),
        ('name = "a"\nkind = "servo"\nservo = "finger"\npress_us = 2400.0', "should be within 1000 to 2000"),
        ('name = "a"\nkind = "mavlink"\ncomponent = 1', "camera[1].component"),
        ('name = "a"\nkind = "relay"\nrelay = "shutter"\npulse_s = 1.0', "should be 2 or more, twice pulse_s"),
        (
            'name = "a"\nkind = "relay"\nrelay = "shutter"\n[[camera]]\nname = "b"\nkind = "relay"\nrelay = "shutter"',
            "'a' has it too",
        ),
        (
            'name = "a"\nkind = "mavlink"\ncomponent = 100\n[[camera]]\nname = "a"\nkind = "mavlink"\ncomponent = 101',
            "'a' is used twice",
        ),
    ],
)
def test_every_fault_is_told_with_its_line(camera: str, problem: str) -> None:
    (found,) = parsed(f"[[camera]]\n{camera}\n")
    assert problem in found and found.startswith("boat.toml:")
