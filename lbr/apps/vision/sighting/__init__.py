"""Sighting: reports the direction of a coloured thing or a face in a camera's picture, on request; it moves nothing."""
