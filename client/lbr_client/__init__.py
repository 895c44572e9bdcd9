"""A program's connection to a robot, without an installed lbr: the exports of `lbr.client`.

It brings the modules of lbr that it needs, in a folder at the end of the path: an installed lbr has priority.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).with_name("_modules")))

from lbr.client import *  # noqa: F403 - whatever it exports, once it can be found
from lbr.client import __all__ as __all__
