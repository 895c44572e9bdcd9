"""A robot runtime: rows become processes, Zenoh is the bus, the console drives."""
