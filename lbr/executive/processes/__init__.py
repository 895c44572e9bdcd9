"""Starts, watches, restarts and ends what a plan says, and gives each process its place on the bus."""
