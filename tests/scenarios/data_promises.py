"""What rows, audit trail and latch survive, with targets and hard limits."""

from tests.support.figures import Promise

PROMISES: dict[str, Promise] = {
    "D1": Promise(what="kill -9 during writes: 0 acknowledged lost, integrity and foreign keys clean"),
    "D2": Promise(what="mutated databases: refused by name or as meant, exit code 2, no traceback"),
    "D2 time": Promise(what="check of a mutated database", target=2000, hard=4000),
    "D4": Promise(what="truncations, flipped bits, missing log: refused clearly, or the very same rows"),
    "D4 restore": Promise(
        what="`lbr db restore` after damage gives the last good rows back, and keeps the damaged file"
    ),
    "D4 full": Promise(what="full disk: told in one line at a start, written down later"),
    "D4 recovered": Promise(what="room made again, to no problem", target=2000, hard=5000),
    "D6": Promise(what="audit trail over kills and restarts: whole, and nothing acknowledged is missing"),
    "E2": Promise(what="the latch survives kill -9, full disk and locked database; nothing drives"),
    "E6 full": Promise(what="estop with a full disk, to motor zero; told once", target=100, hard=250),
    "E6 locked": Promise(what="estop with a locked database, to motor zero; told once", target=100, hard=250),
}
