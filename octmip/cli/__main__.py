"""``python -m octmip.cli``."""

import sys

from octmip.cli import main

sys.exit(main())
