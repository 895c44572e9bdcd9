"""Each type of device that lbr emulates itself: its rows, its faults, its twin. Light to import: the executive reads
rows by them."""
