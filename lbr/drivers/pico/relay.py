"""`python -m lbr.drivers.pico.relay on|off|show`: the power of the motors by the relay of a UPS PIco.

For a systemd unit, before and after a robot runs. Exit code 0: done, and read back; 1: failed.
"""

import argparse
import sys
import time
from collections.abc import Sequence

from lbr.capability.context import Device
from lbr.drivers.i2c import open_bus
from lbr.drivers.i2c_bus import Bus
from lbr.drivers.pico.registers import COMMANDS_ABOVE, RELAY, STATUS_ADDRESS
from lbr.errors import DeviceError

PACE_S = 0.1


def main(arguments: Sequence[str] | None = None) -> int:
    """Switch or show; retry for a while if the bus is missing or the supply does not answer."""
    asked = _parser().parse_args(arguments)
    device = Device("ups", "pico", asked.address, {})
    until = time.monotonic() + asked.within_s
    while True:
        try:
            print(_done(device, asked.do, asked.on_is))
        except OSError as err:
            if time.monotonic() < until and not _hopeless(err):
                time.sleep(PACE_S)
                continue
            print(f"the motors' power could not be switched: {err}", file=sys.stderr)
            return 1
        else:
            if asked.do == "on":
                time.sleep(asked.settle_s)
            return 0


def _done(device: Device, do: str, on_is: int) -> str:
    bus, address = open_bus(device, STATUS_ADDRESS)
    try:
        return _switched(bus, address + COMMANDS_ABOVE, do, on_is)
    finally:
        bus.close()


def _switched(bus: Bus, address: int, do: str, on_is: int) -> str:
    wanted = on_is if do == "on" else 1 - on_is
    if do != "show":
        bus.write_byte_data(address, RELAY, wanted)
        time.sleep(PACE_S)
    found = bus.read_byte_data(address, RELAY)
    if do != "show" and found != wanted:
        raise OSError(f"the relay reads {found:#04x} after {wanted} was written; look at the supply")
    return f"the motors' power is {'on' if found == on_is else 'off'}"


def _hopeless(err: OSError) -> bool:
    """Return whether a retry is useless: a malformed address stays malformed."""
    return isinstance(err, DeviceError) and err.__cause__ is None


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m lbr.drivers.pico.relay", description=__doc__)
    parser.add_argument("do", choices=("on", "off", "show"))
    parser.add_argument("--address", default="i2c:1:0x69", help="as in a device row; default %(default)s")
    parser.add_argument("--on-is", type=int, choices=(0, 1), default=1, help="what the relay reads when there is power")
    parser.add_argument("--within-s", type=float, default=5.0, help="how long to try; default %(default)s")
    parser.add_argument(
        "--settle-s", type=float, default=0.5, help="how long to wait after it is on; default %(default)s"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
