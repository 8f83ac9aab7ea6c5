"""`python -m gcs_plugins.blueos serve | write`: the extension's web server, or cockpit_extras.json anew from the
table."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from http.server import ThreadingHTTPServer

from gcs_plugins.blueos import cockpit
from gcs_plugins.blueos.server import PORT, Handler


def main(argv: Sequence[str] | None = None) -> int:
    """Serves until it is ended."""
    parser = argparse.ArgumentParser(prog="python -m gcs_plugins.blueos")
    parser.add_argument("what", choices=("serve", "write"))
    parser.add_argument("--port", type=int, default=PORT)
    arguments = parser.parse_args(argv)
    if arguments.what == "write":
        cockpit.EXTRAS.write_text(cockpit.text(), encoding="utf-8")
        return 0
    with ThreadingHTTPServer(("", arguments.port), Handler) as server:
        server.serve_forever()
    return 0


if __name__ == "__main__":
    sys.exit(main())
