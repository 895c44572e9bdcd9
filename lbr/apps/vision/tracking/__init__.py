"""Tracking: the head follows a coloured thing or a face that its camera sees, under a lease as anybody else's
motion."""
