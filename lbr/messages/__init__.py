"""Every message type, by family: the content of the bus, with units and bounds in the types."""
