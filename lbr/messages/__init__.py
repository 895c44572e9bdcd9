"""Every message type, by family: what may travel on the bus, with units and bounds in the types."""
