"""Turns measured in a simulated world that runs in lockstep: the kernel's, and the open loop they replace."""
