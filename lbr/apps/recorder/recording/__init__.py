"""Recordings: MCAP files of a robot's black box, readable even if they are cut or damaged.

`chunks` makes and parses the bytes, `segments` writes a file, `reader` reads one. `shelf` knows the folders, `times`
parses times, and `export` writes files for other programs. Only this package knows MCAP.
"""
