"""Starts, watches, restarts and ends the processes of a plan, and gives each its place on the bus."""
