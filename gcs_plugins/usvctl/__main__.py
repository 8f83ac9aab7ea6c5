"""`python -m gcs_plugins.usvctl`."""

import sys

from gcs_plugins.usvctl.cli import main

sys.exit(main())
