"""What root gives up as its process is confined."""

import os
import sys

from lbr.capability import confine as confined
from tests.support import needs, programs

CONFINED = """
import sys
from lbr.capability.confine import confine
confine(sys.argv[1:])
print(open('/proc/self/status').read())
"""


def held(*places: str) -> int:
    done = programs.run([sys.executable, "-c", CONFINED, *places], capture_output=True, text=True, check=True)
    (effective,) = (line.split()[1] for line in done.stdout.splitlines() if line.startswith("CapEff:"))
    return int(effective, 16)


@needs.root("has something to give up")
def test_root_keeps_nothing_unless_a_place_belongs_to_another(tmp_path):
    foreign = tmp_path / "foreign"
    foreign.touch()
    os.chown(foreign, 1, 1)
    assert held(str(tmp_path), "/no/such/device", "usb:20d2:5740") == 0
    assert held(str(tmp_path), str(foreign)) == 1 << confined.CAP_DAC_OVERRIDE
