"""Sighting: reports where a camera sees a coloured thing or a face, while that is asked for; it moves nothing."""
