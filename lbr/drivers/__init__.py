"""Drivers: each owns one device, speaks its protocol and decides last what it does."""
