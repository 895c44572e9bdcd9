"""Tracking: the head follows a coloured thing or a face in its camera's picture, under a lease."""
