"""How long a text is with usual values in its places, and why some have to be long."""

from __future__ import annotations

import re

CHUNK = 50
"""Characters of one STATUSTEXT message."""

PLACES = re.compile(r"\{[^}]*\}")
_NUMBER = "12.3"
_SENTENCE = "outside the fence"
EXAMPLES = {  # usual values of the places that are no numbers
    "ValueError": "setpoint is not finite",
    "at": "12",
    "battery_text": "21 % left",
    "before": "gnss",
    "beyond": _SENTENCE,
    "blocked": _SENTENCE,
    "custom_mode": "65536",
    "ends": "Position is back",
    "error": _SENTENCE,
    "fault": _SENTENCE,
    "fence": "Outside the fence",
    "found": "no home",
    "get_type": "COMMAND_LONG",
    "item_number": "12",
    "label": "OSLOFJORD 3",
    "lat_deg": "59.123456",
    "leader_fault": "leader not heard",
    "lon_deg": "10.123456",
    "lost_motions": "sideways thrust",
    "message": "12",
    "met": "crossing from starboard",
    "mode": "Heading",
    "name": "starboard",
    "name_of": "DO_SET_SERVO",
    "names": "port, starboard",
    "number": "12",
    "off_m": "3.4",
    "plan": "mission",
    "reason": _SENTENCE,
    "refusal": _SENTENCE,
    "remedy": "give 0 to 8",
    "replace": "out of range",
    "rule": "FOLL_AUTH is 0",
    "said": "20 m, clockwise",
    "seq": "12",
    "side": "starboard",
    "silent": "255",
    "silent_bridges": "bridge",
    "situation": "Position lost",
    "source": "gnss",
    "strerror": "No such file",
    "system": "255",
    "system_id": "255",
    "text": _SENTENCE,
    "target": "12",
    "up": "no sideways thrust",
    "version": "2.0.0",
    "wish": "remote control",
}

WHY_LONG = {
    "Fence and obstacles not guarded ({name}: {error})": "the error inside the program",
    "Traffic: {label} {met}, {max} m in {due_s} s": "the vessel's name, how it meets the boat, how near and when",
    "Traffic: {label} {met}, {max} m in {due_s} s; it gives way": "likewise, and who gives way",
    "{ends}: stays in {mode}: another failsafe lasts": "what is over, and why the boat does not go back",
    "{get_type} not handled: {name}: {error}": "the error inside the program",
    "{mode}: {names} not down, {up}": "the thrusters' names, and what is left",
}
"""Texts that come in more than one message, and why."""


def usual_length(text: str) -> int:
    """Characters of a text with places in braces, with usual values there."""
    return len(PLACES.sub(lambda found: EXAMPLES.get(found[0][1:-1], _NUMBER), text))
