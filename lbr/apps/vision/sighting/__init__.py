"""Sighting: tells where a coloured thing or a face is that a camera sees, while that is asked for; it moves nothing."""
