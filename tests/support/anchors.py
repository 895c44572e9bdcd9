"""What the best of other robots, supervisors and controllers are known to do, figure by figure."""

ANCHORS: dict[str, str] = {
    "S1": "250 ms, a controller's watchdog alone",
    "S2": "200 ms, ArduPilot Rover",
    "S3": "500 ms, diff_drive; 2,000 ms, Viam",
    "S4": "500 ms, diff_drive",
    "S6": "500 ms",
    "S6 gone": "10 s, ros2 launch",
    "S8": "2,000 ms, Viam",
    "S9": "500 ms, PX4; 10 s, Zenoh's default",
    "S11": "1,000 ms, Roboteq's default",
    "S13": "2,000 ms, Viam",
    "S13 gone": "never: callback threads keep a Python process alive",
    "S14": "a Roboteq resumes its old speed",
    "S15": "2,000 ms, nav2 collision monitor",
    "S16": "1,000 ms, Reachy Mini",
    "S17": "20 s of stale commands in a pty",
    "S18 range": "4 to 20 ms a frame, nav2 collision monitor",
    "E1 console": "3.9 ms p99, a prototype",
    "E1 put": "3.9 ms p99, a prototype",
    "E1 console H": "55 ms p99, a prototype; 7 raised",
    "E1 put H": "55 ms p99, a prototype; 7 raised",
    "E1 console G": "18 s behind a slow callback",
    "E1 put G": "18 s behind a slow callback",
    "E2": "Klipper: latched until a restart",
    "E5": "ISO 13850: anyone, in all modes",
    "F1": "58 stale commands after a healed partition",
    "F4": "diff_drive goes by the sender's stamp",
    "P1 motors": "5 s, Viam; 100 ms, systemd",
    "P1 drive": "5 s, Viam; 100 ms, systemd",
    "P2": "Erlang: 1 in 5 s; systemd: 5 in 10 s, then failed",
    "P4 gone": "5 s and 5 s, ros2 launch",
    "P5 gone": "1 s heartbeat, 4 s to notice, nav2 lifecycle",
    "B1 I": "20.6 ms p99, 71 max, a prototype",
    "B1 H": "33 ms p99, 494 max, a prototype",
    "D1": "SQLite: 18,535 commits over 200 kills, none lost",
    "Z4": "router alone: 5,000 malformed connections",
}


def anchor(figure: str) -> str:
    """Return what a figure is to be held against; empty if nothing is known."""
    return ANCHORS.get(figure, "")
