"""What chance at every way into a robot may never bring about."""

from tests.support.figures import Promise

PROMISES: dict[str, Promise] = {
    "F6": Promise(what="outputs within the configured maximum and slew, in every scenario"),
    "Z1": Promise(what="console lines by chance, in a pipe and on a terminal, against a model of what is accepted"),
    "Z1 answer": Promise(what="console line by chance, to its answer and two more", target=50, statistic="p99"),
    "Z4": Promise(what="payloads, attachments and encodings by chance on every key, outside and inside"),
    "Z4 sockets": Promise(what="garbage connections to the sockets: random bytes, cut and bent handshakes"),
    "Z4 memory": Promise(what="growth of any process over that", unit="MB", target=20, hard=50),
    "Z5": Promise(what="device lines: noise, flipped bits, cuts, dribble, merged and dropped bytes, pulled cables"),
    "Z5 frames": Promise(what="whole frames after noise until a reading is published", unit="", target=2, hard=3),
    "Z7": Promise(what="walks over console, bus, rows, emergency stop, kills: outputs are always explained"),
}
