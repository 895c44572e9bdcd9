"""Sounds for apps that play some: WAV files, safe names of files, and sinks that report whether a sound was played."""
