"""Protocol 1.0 of Dynamixel, for every make of servo that speaks it: packets, the line, transactions, registers.

A driver subclasses `bus.ProtocolBus` with its own control table: `lbr/drivers/dynamixel/bus.py` is one.
"""
