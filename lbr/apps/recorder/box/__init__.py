"""The black box: every stream, event and line of a log, always, into files that survive a power cut.

`inbox` receives from the bus, `logs` reads what processes write, `disk` writes beside the main loop, `keeping` decides what is
kept for longer, `clock` dates what others say. It only listens, and nothing waits for it.
"""
