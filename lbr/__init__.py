"""A robot runtime: rows become processes, Zenoh is the wire, the console drives."""
