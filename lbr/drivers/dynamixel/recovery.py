"""Recovery of a servo from a latched fault: only when its cause is gone; the servo stays without torque."""

from collections.abc import Callable

from lbr.drivers.dynamixel import table
from lbr.drivers.dynamixel.bus import STATE_ADDRESS, STATE_BYTES, Bus
from lbr.drivers.dynamixel.packet import error_names
from lbr.drivers.dynamixel.setup import Kept

COOLER_C = 5
"""The margin below its limit at which a servo counts as cooled down."""


def recovery(servo: int, eeprom: Kept) -> Callable[[Bus], str]:
    """Return the job that recovers a servo; the job returns the reason for a failure, or an empty string."""

    def job(bus: Bus) -> str:
        status = bus.read(servo, STATE_ADDRESS, STATE_BYTES)
        if status is None:
            return bus.trouble
        if wrong := _cause(status.error, status.params, eeprom):
            return wrong
        if not bus.put(servo, table.TORQUE_ENABLE, 0) or not bus.put(servo, table.TORQUE_LIMIT, eeprom.max_torque):
            return "does not acknowledge"
        if not bus.get(servo, table.TORQUE_LIMIT):
            return "latches again at once"
        return ""

    return job


def _cause(error: int, block: bytes, eeprom: Kept) -> str:
    """Return the fault that persists. An overload shows under torque only; its bit stays until that limit is set."""
    names = set(error_names(error & eeprom.shutdown))
    temperature = table.PRESENT_TEMPERATURE.decode(block, STATE_ADDRESS)
    tenths = table.PRESENT_VOLTAGE.decode(block, STATE_ADDRESS)
    if "overheat" in names or temperature > eeprom.temperature_limit - COOLER_C:
        limit = eeprom.temperature_limit - COOLER_C
        return f"is still too hot: {temperature} degrees C, and {limit} are allowed; let it cool down"
    if "voltage" in names:
        allowed = f"{eeprom.lowest_voltage / 10:g} to {eeprom.highest_voltage / 10:g} V"
        return f"has {tenths / 10:g} V, outside {allowed}; look at its supply"
    return ""
