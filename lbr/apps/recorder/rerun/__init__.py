"""Reruns a recorded robot: its own processes, on emulated devices that send the recorded bytes.

`rows` makes a home for it, `ends` emulates its devices, and `feed` sends the recorded commands. `alike` compares its
outputs with the recorded ones, and `check` runs all of it.
"""
