"""`python -m sitl.native`."""

from sitl.native.build import main

raise SystemExit(main())
