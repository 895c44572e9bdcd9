"""A robot on wheels in the simulated world, stepped apart from wall time: its capabilities as they are, in one process.

    trying ──► trial ──► stage: drive, beacon, behaviours, battery, odometry, each in the loop and context of its own process
                    └──► instruments: what drivers would tell of the world, with their rates, delays and noise
                              └──► the world's engine

Nothing here opens a bus, a device or a file, and nothing outside moves. `places` says where trials begin, `faults` what
may be wrong in them.
"""
