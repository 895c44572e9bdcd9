"""Programs that drive a robot from outside, to be killed."""
