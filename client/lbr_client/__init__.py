"""A program's way to a robot, where lbr is not installed: what `lbr.client` exports.

The modules of lbr that it needs come along in a folder that stands last on the path: an lbr that is installed goes
before.
"""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).with_name("_modules")))

from lbr.client import *  # noqa: F403 - whatever it exports, once it can be found
from lbr.client import __all__ as __all__
