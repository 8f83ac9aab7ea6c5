"""Compiles the modules of `modules.py` with mypyc and a C compiler.

The work stays in `build/native`; what changes is compiled anew, the rest is kept. The library goes to
`companion/_native`, where `companion/native.py` finds it.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from companion.native import FOLDER, LIBRARY, ROOT, SUFFIX, digest, stamp
from sitl.native.modules import compiled, known
from sitl.native.operations import HEADER
from sitl.native.source import prepared

GROUP = "usv"
FLAGS = (
    *("-O2", "-fPIC", "-fno-plt", "-fvisibility=hidden", "-fwrapv", "-ffp-contract=off", "-fno-math-errno"),
    *("-fno-builtin-pow", "-DNDEBUG", "-w"),
)
"""Results stay as interpreted ones: no fused multiply-add, which some processors have and which rounds once less, and
no `x * x` in place of `x ** 2`, for which Python asks the C library."""

_HEADERS = (f"__native_{GROUP}.h", f"__native_internal_{GROUP}.h")
"""What all C files include; read once, since it is larger than most of them."""

_WRONG, _RIGHT = "!= -113.0 && PyErr_Occurred()", "!= -113.0 || !PyErr_Occurred()"
"""How mypyc 2.4 asks whether a constant that is a tuple of floats has its value, and how it should."""


class BuildError(Exception):
    """What the compiler says."""


def build(folder: Path, compiler: Sequence[str], jobs: int, root: Path = ROOT, into: Path = FOLDER) -> Path:
    """Compile. `folder`: keeps what can be used again. `compiler`: of C, as a command; `jobs`: how many of it run at
    once. Returns the library's path. Raises BuildError."""
    modules, files = compiled(root), known(root)
    changed, made_of = stamp(root, files), digest(root, files)  # what changes while the compiler runs makes it stale
    sources = folder / "src"
    _prepare(root, sources, modules)
    _translate(folder, sources, modules)
    objects = _compiled(folder / "c", folder / "o", compiler, jobs)
    into.mkdir(parents=True, exist_ok=True)
    index, library = into / "index.json", into / f"{LIBRARY}{SUFFIX}"
    index.unlink(missing_ok=True)  # until the library is there, it does not count
    part = library.with_suffix(".part")
    _run([*compiler, "-shared", "-Wl,-Bsymbolic", "-o", str(part), *map(str, objects), "-lm"])
    part.replace(library)
    index.write_text(
        json.dumps(
            {
                "for": f"{sys.implementation.cache_tag}, {sysconfig.get_platform()}",
                "by": "mypyc",
                "modules": [module.removesuffix(".py").replace("/", ".") for module in modules],
                "files": files,
                "digest": made_of,
                "stamp": changed,
            },
            indent=1,
        )
    )
    return library


def _prepare(root: Path, sources: Path, modules: Sequence[str]) -> None:
    """Lay the packages out as mypyc gets them. A file that is the same is left alone, for mypy's cache."""
    wanted = {str(path.relative_to(root)) for top in ("companion", "sitl") for path in (root / top).rglob("*.py")}
    for path in sources.rglob("*.py"):
        if str(path.relative_to(sources)) not in wanted:
            path.unlink()
    for name in wanted:
        text = (root / name).read_text(encoding="utf-8")
        try:
            text = prepared(text) if name in modules else text
        except ValueError as error:
            raise BuildError(f"{name}: {error}") from error
        path = sources / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def _translate(folder: Path, sources: Path, modules: Sequence[str]) -> None:
    """Make C of the modules, in a process of its own: mypyc ends the process where it finds a mistake."""
    code = (
        "import json, sys; from mypyc.build import mypycify; from sitl.native.operations import register;"
        "given = json.load(sys.stdin); sys.setrecursionlimit(20000); register();"
        f"mypycify(given, multi_file=True, group_name='{GROUP}', target_dir=sys.argv[1])"
    )
    shutil.rmtree(folder / "c", ignore_errors=True)  # it may hold modules that are no longer compiled
    config = folder / "mypy.ini"
    config.write_text(
        "[mypy]\nstrict = True\nignore_missing_imports = True\nwarn_unused_ignores = False\nwarn_unreachable = True\n"
    )
    cache = ("--config-file", str(config), "--cache-dir", str(folder / "cache"))
    _run([sys.executable, "-c", code, str(folder / "c")], sources, json.dumps([*cache, *modules]))
    for path in (folder / "c").glob("*.c"):
        text = path.read_text(encoding="utf-8")
        if _WRONG in text:
            path.write_text(text.replace(_WRONG, _RIGHT), encoding="utf-8")


def _compiled(sources: Path, objects: Path, compiler: Sequence[str], jobs: int) -> list[Path]:
    """Compile all C files but those whose text and headers have an object. Returns the objects."""
    from mypyc.build import include_dir

    headers = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(sources.glob("__native*.h"))))
    headers.update(" ".join(FLAGS).encode() + HEADER.read_bytes())
    objects.mkdir(parents=True, exist_ok=True)
    include = [f"-I{path}" for path in (sources, include_dir(), sysconfig.get_paths()["include"])]
    common = sources / "common.h"
    common.write_text("".join(f'#include "{name}"\n' for name in (HEADER, *_HEADERS)))
    _run([*compiler, *FLAGS, *include, "-x", "c-header", str(common), "-o", f"{common}.gch"])
    include += ["-include", str(common)]

    def compile_one(source: Path) -> Path:
        key = headers.copy()
        key.update(source.read_bytes())
        found = objects / f"{source.stem.strip('_')}-{key.hexdigest()[:16]}.o"
        if not found.exists():
            part = found.with_suffix(".part")
            _run([*compiler, *FLAGS, *include, "-c", str(source), "-o", str(part)])
            part.replace(found)
        return found

    with ThreadPoolExecutor(jobs) as pool:
        kept = list(pool.map(compile_one, sorted(sources.glob("*.c"))))
    for path in set(objects.iterdir()) - set(kept):
        path.unlink()
    return kept


def _run(command: Sequence[str], folder: Path | None = None, text: str = "") -> None:
    try:
        done = subprocess.run(command, cwd=folder, input=text, capture_output=True, text=True, check=False)
    except OSError as error:
        raise BuildError(f"{command[0]}: {error.strerror}") from error
    if done.returncode:
        lines = (done.stdout + done.stderr).splitlines()
        raise BuildError("\n".join([line for line in lines if " warning: " not in line][-30:]))
