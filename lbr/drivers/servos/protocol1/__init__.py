"""Protocol 1.0 of Dynamixel, for servos of all makes that use it: packets, the line, transactions, registers.

A driver subclasses `bus.ProtocolBus` with its own control table, as `lbr/drivers/dynamixel/bus.py` does.
"""
