"""Sounds for any app that plays some: WAV files, names that are safe as files, and sinks that report whether they were
heard."""
