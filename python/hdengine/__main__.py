# SPDX-License-Identifier: GPL-3.0-or-later
"""python -m hdengine: same as the command `hdengine`."""
from .cli import main

raise SystemExit(main())
