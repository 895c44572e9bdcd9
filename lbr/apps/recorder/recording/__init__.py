"""Recordings: MCAP files that a robot's black box writes, and that are read whatever became of their end.

`chunks` makes and reads the bytes, `segments` writes a file, `reader` reads what is left of one, `shelf` knows the
folders, `times` understands when people mean, `export` writes files for others. Only this package knows MCAP.
"""
