"""Recognition of a bus of AX-12A: ids 1 to 20 are asked for their model number, a read-only register."""

from lbr.capability.recognition import Seen, SerialHandshake
from lbr.drivers.servos.protocol1 import packet

IDS = range(1, 21)
MODEL_ADDRESS = 0
MODELS = {12: "AX-12", 18: "AX-18", 300: "AX-12W"}


def seen(answer: bytes) -> Seen | None:
    """Return the servos whose model number belongs to this family."""
    numbers = {
        one.id: int.from_bytes(one.params, "little")
        for one in packet.StatusParser().feed(answer)
        if len(one.params) == 2
    }
    models = {servo: MODELS[model] for servo, model in numbers.items() if model in MODELS}
    if not models:
        return None
    names = " and ".join(sorted(set(models.values())))
    return Seen(what=f"bus of {len(models)} Dynamixel {names}: ids {', '.join(map(str, sorted(models)))}")


HANDSHAKE = SerialHandshake(
    baud=1_000_000,
    questions=tuple(packet.read(servo, MODEL_ADDRESS, 2) for servo in IDS),
    gap_s=0.008,
    listen_s=0.06,
    whole=True,
    seen=seen,
)
