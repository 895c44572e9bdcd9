"""Feetech STS3215 servos as a package outside lbr would drive and emulate them: nothing in lbr is edited for it."""
