"""Coverage-guided fuzzing of one target, by atheris (extra `fuzz`):

    python -m tests.fuzz.run framer --runs 1000000

A breach ends it with the input, as a line for `tests/fuzz/corpus/TARGET.txt`. Afterwards `--keep` adds to that file what
reached new code, as far as it is short; the normal tests replay the file.
"""

from __future__ import annotations

import argparse
import base64
import sys
from pathlib import Path
from typing import Any

CORPUS = Path(__file__).parent / "corpus"
_MOST_KEPT, _LONGEST = 48, 2048


def main() -> int:
    """Fuzz one target."""
    parser = argparse.ArgumentParser(description="coverage-guided fuzzing of one reader of bytes from outside")
    parser.add_argument("target")
    parser.add_argument("--runs", type=int, default=100_000)
    parser.add_argument("--seconds", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--max-len", type=int, default=4096, help="of an input, in bytes")
    parser.add_argument("--work", type=Path, required=True, help="folder of the growing corpus")
    parser.add_argument("--keep", action="store_true", help="do not fuzz: keep the shortest of what was found")
    arguments = parser.parse_args()
    work = arguments.work / arguments.target
    work.mkdir(parents=True, exist_ok=True)
    if arguments.keep:
        return _keep(arguments.target, work)
    import atheris  # type: ignore[import-not-found,unused-ignore]

    with atheris.instrument_imports(include=["companion"]):
        from tests.fuzz.seeds import SEEDS
        from tests.fuzz.targets import TARGETS
    for number, seed in enumerate((*SEEDS[arguments.target](), *lines(arguments.target))):
        (work / f"seed-{number}").write_bytes(seed)
    options = [f"-runs={arguments.runs}", f"-seed={arguments.seed}", "-timeout=10", "-rss_limit_mb=2048"]
    options += [f"-max_total_time={arguments.seconds}", f"-artifact_prefix={arguments.work}/{arguments.target}-"]
    options += [f"-max_len={arguments.max_len}", "-print_final_stats=1", "-verbosity=1", str(work)]
    run: Any = TARGETS[arguments.target]
    atheris.Setup([sys.argv[0], *options], run)
    atheris.Fuzz()
    return 0


def lines(target: str) -> list[bytes]:
    """The kept inputs of a target."""
    path = CORPUS / f"{target}.txt"
    if not path.exists():
        return []
    return [base64.b64decode(line) for line in path.read_text(encoding="ascii").splitlines()]


def _keep(target: str, work: Path) -> int:
    """Spread over what was found, by length: the shortest inputs reach least, the longest are the slowest."""
    known = lines(target)
    found = sorted({path.read_bytes() for path in work.iterdir() if path.stat().st_size <= _LONGEST}, key=len)
    found = [data for data in found if data and data not in known]
    room = max(0, _MOST_KEPT - len(known))
    chosen = found[:: max(1, -(-len(found) // room))] if room else []
    text = "".join(base64.b64encode(data).decode() + "\n" for data in (*known, *chosen))
    (CORPUS / f"{target}.txt").write_text(text, encoding="ascii")
    print(f"{target}: {len(known)} kept before, {len(chosen)} new, of {len(found)} found")
    return 0


if __name__ == "__main__":
    sys.exit(main())
