"""Why a part of a robot stands still: pure, out of one look at its rows and at what it says of itself."""
