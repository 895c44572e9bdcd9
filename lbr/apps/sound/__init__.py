"""Sounds for whatever app plays some: WAV files, names that are safe as files, and sinks that say if they were
heard."""
