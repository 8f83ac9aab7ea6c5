"""Which modules are compiled, and from which other files their types come."""

from __future__ import annotations

from pathlib import Path

_COMPILED = (
    *(f"companion/{room}/" for room in ("core", "nav", "guidance", "control", "allocation", "positioning", "payload")),
    *(f"companion/{room}/" for room in ("fence", "following", "traffic", "obstacles", "modes", "supervisor", "record")),
    *("companion/loop.py", "companion/containment.py", "companion/safety.py", "companion/clock.py"),
    *("companion/params/", "companion/mission/"),
    *("companion/baselines/", "companion/io/sensors/", "companion/io/actuators/"),
    *(f"companion/io/mavlink/{part}" for part in ("commands/", "services/", "telemetry/", "transfer/")),
    *(
        f"companion/io/mavlink/wire/{part}.py"
        for part in (
            "actions",
            "exposure",
            "framer",
            "guard",
            "link_options",
            "personas",
            "proof",
            "reception",
            "repeats",
            "router",
            "signing",
            "slots",
            "spare",
            "stream_memory",
            "yielding",
        )
    ),
    *("companion/io/corrections.py", "companion/io/formats.py", "companion/io/host.py", "companion/io/known_time.py"),
    *("companion/io/listening.py", "companion/io/nmea_out.py", "companion/io/rc_receiver.py", "companion/io/rtcm.py"),
    "sitl/",
)
"""Files and folders of what a tick does, and of what others inherit from: classes of a compiled module can only be
inherited from in compiled modules."""

_INTERPRETED = (
    *("companion/core/ports.py", "sitl/emulators/device.py"),  # runtime_checkable
    "companion/fence/area.py",  # mypyc does not know `cls.__new__`
    *(
        "companion/obstacles/chart_water.py",
        "companion/obstacles/way_round.py",
    ),  # fields of a type not imported
    "companion/io/mavlink/commands/table.py",  # its rows name constants that mypyc cannot tell the types of
    "companion/mission/markup.py",  # a class of another package's class
    "companion/params/transmitter.py",  # an enumeration with `__new__`
    "companion/io/sensors/nmea0183_sentences.py",  # classes with a metaclass
    "companion/record/feed.py",  # the name `_thread` becomes a word of C
    "companion/record/retention.py",
    "companion/record/writer.py",
    "sitl/emulators/mavlink_servo.py",  # mypyc does not know a starred index
    *(
        "sitl/evaluate/",
        "sitl/fault_matrix/",
        "sitl/hunt/",
        "sitl/native/",
        "sitl/scenarios/",
        "sitl/sweep/",
    ),  # above the tick
    *("sitl/hidden_hull.py", "sitl/json_physics.py", "sitl/plant_process.py"),
)

_ABOVE = ("analysis", "cli", "console", "leader_module", "scripting")  # of which no compiled module knows
_BESIDE = ("evaluate", "fault_matrix", "hunt", "native", "scenarios", "sweep")


def compiled(root: Path) -> list[str]:
    """The compiled files, relative to `root`."""
    return [
        name
        for name in known(root)
        if name.startswith(_COMPILED) and not name.startswith(_INTERPRETED) and not name.endswith("__init__.py")
    ]


def known(root: Path) -> list[str]:
    """The compiled files, and all others that they may import: a build counts while these are as they were."""
    above = tuple(f"companion/{room}/" for room in _ABOVE) + tuple(f"sitl/{room}/" for room in _BESIDE)
    names = (str(path.relative_to(root)) for top in ("companion", "sitl") for path in (root / top).rglob("*.py"))
    return sorted(name for name in names if not name.startswith((*above, "companion/_native/")))
