"""A robot on wheels in the simulated world, stepped apart from wall time: its real capabilities, in one process.

    trying ──► trial ──► stage: drive, beacon, behaviours, battery, odometry, each in the loop and context of its own
                    └──► instruments: the drivers' reports of the world, with their rates, delays and noise
                              └──► the world's engine

Nothing here opens a bus, a device or a file, and no real robot moves. `places` has the start places of trials, `faults`
their faults.
"""
