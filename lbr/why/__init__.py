"""Why a part of a robot stands still: pure, from one look at its rows and its messages."""
