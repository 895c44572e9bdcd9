"""A recorded robot runs again: its own processes, on emulated devices that say what the recorded ones said.

`rows` makes it a home of its own, `ends` are its devices, `feed` says the recorded commands to it, `alike` compares
what it does with what was recorded, `check` does all of it in turn.
"""
