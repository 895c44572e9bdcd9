"""The tests of lbr. What they import is compiled once: a robot is ten processes, and each would compile it."""

import os
import sys

os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
