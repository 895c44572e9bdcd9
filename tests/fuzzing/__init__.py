"""Inputs made by chance, from a seed, for every way into a robot."""
