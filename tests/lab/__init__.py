"""A Debian machine without hardware: built from Debian's own packages, run in QEMU, with devices played to its kernel.

    python -m tests.lab build     once: root file system, the project's wheel in it, the first start, a snapshot
    python -m tests.lab run       the tests of tests/kernel in it, from the snapshot; prints a table
    python -m tests.lab service   the robot as a service: boot, kills, shutdown in motion, power cuts; prints a table
    python -m tests.lab network   two machines and a cable: found, driven, cut, frozen, killed, clocks set; prints a table
    python -m tests.lab table     the tables of the last runs
    python -m tests.lab shell     a shell of root in it

Needs root, and mmdebstrap, qemu-system-x86, qemu-utils, e2fsprogs and openssh-client, two machines faketime; docs/lab.md has the rest.
"""
