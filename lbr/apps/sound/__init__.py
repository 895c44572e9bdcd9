"""Sounds for any app that plays some: WAV files, safe names of files, and sinks that say whether they were heard."""
