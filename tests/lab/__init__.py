"""A Debian machine without hardware: built from Debian's own packages, run in QEMU, with devices played to its kernel.

    python -m tests.lab build     once: root file system, the project's wheel in it, the first start, a snapshot
    python -m tests.lab run       the tests of tests/kernel in it, or those that are named, from the snapshot; prints a table
    python -m tests.lab robots    the simulated robots, each by `lbr run`: drive, stop, wave, stand up; prints a table
    python -m tests.lab service   the robot as a service: boot, kills, shutdown in motion, power cuts; prints a table
    python -m tests.lab first     the recipe for a Raspberry Pi, followed at the first start of a machine of its own; prints a table
    python -m tests.lab network   two machines and a cable: found, driven, cut, frozen, killed, clocks set; prints a table
    python -m tests.lab table     the tables of the last runs
    python -m tests.lab shell     a shell of root in it

`--arch arm64` has it be one of 64-bit ARM. Needs root, and mmdebstrap, qemu-system-x86 or qemu-system-arm, qemu-utils, e2fsprogs and openssh-client, two
machines faketime; docs/lab.md has the rest.
"""
