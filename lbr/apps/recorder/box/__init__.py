"""The black box: every stream, event and log line, at all times, in files that survive a power cut.

`inbox` receives from the bus, `logs` reads the processes' logs, and `disk` writes beside the main loop. `keeping`
decides which files stay longer, and `clock` dates the messages. The box only listens, and nothing waits for it.
"""
