"""``python -m octmip.interfaces.cli``."""

import sys

from octmip.interfaces.cli import main

sys.exit(main())
