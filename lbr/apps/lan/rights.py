"""The rights of a token's role at the door, and the commands that the relay serves there. Pure."""

from msgspec.structs import replace

from lbr.bus import keys
from lbr.bus.access import Limits, Rights, everything
from lbr.bus.door import LanConfig
from lbr.messages.system import RANKS, Role, TokenRole

RELAY = "@relay"
LARGEST_BYTES = 64 * 1024
MOST_SESSIONS = 64
COMMANDS_HZ = 100.0
STOPS_HZ = 200.0


def of_token(robot: str, lan: LanConfig, name: str, role: TokenRole) -> Rights:
    """Return the rights of a token; a host's token may look, stop, and take the share of the host of its name."""
    if role != "host":
        return of_role(robot, lan, role)
    rights = of_role(robot, lan, "view")
    return replace(rights, ask=(*rights.ask, keys.host(robot, name)), alive=(keys.agent_alive(robot, name),))


def of_role(robot: str, lan: LanConfig, role: Role) -> Rights:
    """Return the rights of a role: everybody looks and stops, operators move, administrators do everything.

    No role receives commands: these contain the lease of their sender, which is valid for each client that quotes it.
    """
    allowed = commands(lan, role)
    return Rights(
        put=(*allowed, *lan.stops, keys.estop(robot)),
        ask=(*allowed, *consoles(robot, role), *lan.stops, *lan.streams, keys.estop(robot), *keys.looked_at(robot)),
        hear=(f"{robot}/**", keys.estop(robot), *keys.looked_at(robot)),
        never_hear=(*lan.commands, *lan.theirs),
        watch=(keys.alive(robot, "*"),),
    )


def of_relay(robot: str, lan: LanConfig) -> Rights:
    """Return the rights of the relay behind the door: it serves the messages that may move or change something."""
    return Rights(
        serve=(*lan.commands, *consoles(robot, "admin")),
        hear=(*lan.commands, keys.status(robot)),
        ask=(keys.status(robot),),
    )


def of_upstream(lan: LanConfig) -> Rights:
    """Return the rights of the robot's side: all but others' commands, which the relay would mistake for new ones."""
    return Rights(trusted=True, never_put=tuple(lan.commands))


def limits(robot: str, lan: LanConfig) -> Limits:
    """Return the limits of one client: nothing large, and nothing more often than a robot can use it."""
    stops = dict.fromkeys((*lan.stops, keys.estop(robot)), STOPS_HZ)
    return Limits(
        protocols=("tls", "tcp"),
        bytes=LARGEST_BYTES,
        keys=everything(robot),
        puts_hz=dict.fromkeys((*lan.commands, *lan.theirs), COMMANDS_HZ) | stops,
        sessions=MOST_SESSIONS,
    )


def commands(lan: LanConfig, role: Role) -> tuple[str, ...]:
    """Return the commands of a role: through the relay, or directly."""
    return tuple(key for key, needed in (lan.commands | lan.theirs).items() if RANKS[needed] <= RANKS[role])


def consoles(robot: str, role: Role) -> tuple[str, ...]:
    """Return the keys of a role's console lines, and for operators that of the emergency stop's reset."""
    own: tuple[Role, ...] = tuple(other for other, rank in RANKS.items() if rank <= RANKS[role])
    reset = (keys.estop_reset(robot),) if RANKS[role] >= RANKS["operate"] else ()
    return (*(keys.console(robot, other) for other in own), *reset)
