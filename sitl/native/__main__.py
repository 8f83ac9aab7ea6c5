"""`python -m native`."""

from native.build import main

raise SystemExit(main())
