"""What the emulated main board plays, made up for lbr: names and times are the factory's, movements are not.

`python -m tests.models.uxa90.choreography` writes it down as `firmware.json`.
"""

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from lbr.robots.uxa90.twin import firmware
from lbr.robots.uxa90.twin.firmware import Frame, Programme
from tests.models.uxa90.gait import Gait, ahead, aside, turned
from tests.models.uxa90.posture import ARMS, BASIC, SITTING, STRAIGHT, Point, Pose, frame, legs

Limb = Callable[..., Pose]

BEAT_S = 0.45
FILE = Path(firmware.__file__).with_name("firmware.json")


def programmes() -> dict[int, Programme]:
    """Return all of them by slot."""
    return {
        1: Programme(name="basic_motion", frames=(frame(BASIC, 0.4, smooth=False),)),
        2: _lasting("kick_right", 11.1, kick()),
        3: Programme(name="turn_left", frames=Gait(turned(0.4, 0.045), 1.5, 0.42, 0.25).frames()),
        4: Programme(name="walk_forward_short", frames=Gait(ahead(2, 0.07), 1.9, 0.5).frames()),
        5: Programme(name="turn_right", frames=Gait(turned(-0.4, 0.045), 1.7, 0.42, 0.25).frames()),
        6: Programme(name="walk_left", frames=Gait(aside(0.05), 2.4, 0.6).frames()),
        7: Programme(name="reset", frames=(frame(STRAIGHT, 6.5), Frame(duration_s=0.5))),
        8: Programme(name="walk_right", frames=Gait(aside(-0.05), 2.5, 0.6).frames()),
        9: Programme(name="walk_forward_4step", frames=Gait(ahead(4, 0.07), 3.1, 0.52).frames()),
        10: Programme(name="basic_motion_down", frames=(frame(BASIC, 0.4, smooth=False),)),
        11: Programme(name="walk_forward_6step", frames=Gait(ahead(6, 0.07), 5.7, 0.75).frames()),
        12: _lasting("demo_introduction", 27.6, introduction()),
        13: _lasting("dance_gangnamstyle", 93.5, dance(), figures()),
        21: Programme(name="sit_down", limp=True, frames=(sit(), Frame(duration_s=1.0))),
    }


def sit() -> Frame:
    """Return the way down, onto the stops of knees, hips and ankles."""
    return frame({**SITTING, **both(shoulder_pitch=0.1, elbow=-0.3)}, 6.0)


def kick() -> list[Frame]:
    """Return a kick with the right foot, all weight on the left one."""
    out = [frame({**ARMS, **legs()}, 0.5)]
    spots: tuple[tuple[float, Point], ...] = (
        *((2.0, (0.0, 0.0, 0.0)), (1.4, (0.0, 0.0, 0.05))),
        *((1.2, (-0.10, 0.0, 0.07)), (0.5, (-0.10, 0.0, 0.07)), (0.35, (0.16, 0.0, 0.08)), (0.65, (0.16, 0.0, 0.08))),
        *((1.2, (0.0, 0.0, 0.05)), (1.5, (0.0, 0.0, 0.0))),
    )
    for lasts_s, foot in spots:
        out.append(frame({**ARMS, **both(shoulder_roll=0.25), **legs(0.056, right=foot)}, lasts_s))
    return [*out, frame({**ARMS, **legs()}, 1.4)]


def introduction() -> list[Frame]:
    """Return a greeting, a bow, and a show of arms and knees."""
    straight = legs()
    waved = right(shoulder_roll=1.5, shoulder_yaw=1.5, shoulder_pitch=0.0)
    bowed = {**legs(0.0, 0.37, 0.5), **both(shoulder_pitch=0.2), "head_pitch": 0.3}
    itself = right(shoulder_pitch=0.7, shoulder_yaw=-0.8, elbow=-2.0)
    open_armed = both(shoulder_pitch=1.1, shoulder_roll=0.4, shoulder_yaw=0.3, elbow=-0.5)
    strong = both(shoulder_roll=1.5, shoulder_yaw=1.5, elbow=-1.9)
    bent = {**legs(0.0, 0.33, 0.15), **both(shoulder_pitch=0.6, elbow=-1.0)}
    waves: list[tuple[float, Pose]] = [
        (0.35, {**waved, **right(elbow=elbow), "neck_yaw": -0.3}) for elbow in (-1.0, -1.8)
    ]
    arms: list[tuple[float, Pose]] = []
    for arm in (left, right):
        reach = arm(shoulder_pitch=1.5, elbow=-0.2)
        arms += [
            (0.8, reach),
            (0.5, arm(shoulder_pitch=1.5, elbow=-1.8, hand=0.3)),
            (0.5, {**reach, **arm(hand=-0.3)}),
            (0.7, {}),
        ]
    acts: list[tuple[float, Pose]] = [
        *((0.6, {}), (1.2, {**waved, **right(elbow=-1.4), "neck_yaw": -0.3}), *waves * 3, (1.2, {})),
        *((1.4, bowed), (0.6, bowed), (1.4, {}), (1.0, {**itself, "head_pitch": 0.2}), (1.0, itself)),
        (1.2, {**open_armed, "neck_yaw": 0.5, "waist_yaw": 0.35}),
        (1.4, {**open_armed, "neck_yaw": -0.5, "waist_yaw": -0.35}),
        *((1.0, open_armed), (1.0, {}), *arms, (1.0, strong), (0.6, {**strong, "head_pitch": -0.2}), (0.8, {})),
        *((0.9, bent), (0.9, {}), (0.6, {"head_pitch": 0.3}), (0.5, {"head_pitch": -0.1})),
    ]
    return [frame({**ARMS, **straight, **pose}, lasts_s) for lasts_s, pose in acts]


def dance() -> list[Frame]:
    """Return the order of the figures."""
    rest = frame({**ARMS, **legs()}, BEAT_S)
    verse = [_figure("ride", 12), rest, _figure("march"), _figure("lasso_right", 4), rest]
    verse += [_figure("sway", 6), rest, _figure("march"), _figure("lasso_left", 4), rest, _figure("box", 5), rest]
    end = [_figure("ride", 8), rest, _figure("sway", 24), rest]
    return [frame({**ARMS, **legs()}, 0.6), *verse, *verse, *end]


def figures() -> dict[str, tuple[Frame, ...]]:
    """Return what the dance consists of."""
    half = BEAT_S / 2
    high, low = legs(0.0, 0.385, 0.05), legs(0.0, 0.362, 0.08)
    reins = both(shoulder_pitch=0.95, shoulder_yaw=-0.7, elbow=-1.1)
    given = both(shoulder_pitch=0.75, shoulder_yaw=-0.7, elbow=-1.25)

    def swung(one: Limb, other: Limb, sense: int) -> Frame:
        arms = {**one(shoulder_pitch=0.6, elbow=-1.0), **other(shoulder_pitch=-0.4)}
        return frame(
            {**ARMS, **legs(0.012 * sense), **arms, "waist_yaw": 0.25 * sense, "neck_yaw": 0.2 * sense}, BEAT_S
        )

    def boxed(one: Limb, other: Limb, sense: int) -> Frame:
        up = one(shoulder_roll=1.4, shoulder_yaw=1.5, elbow=-1.6)
        down = other(shoulder_roll=1.4, shoulder_yaw=-1.3, elbow=-1.6)
        return frame({**ARMS, **high, **up, **down, "neck_yaw": 0.3 * sense}, BEAT_S)

    return {
        "ride": (frame({**ARMS, **low, **given, "head_pitch": 0.1}, half), frame({**ARMS, **high, **reins}, half)),
        "lasso_right": _lasso(right, left),
        "lasso_left": _lasso(left, right),
        "sway": (swung(left, right, 1), swung(right, left, -1)),
        "box": (boxed(left, right, 1), boxed(right, left, -1)),
        "march": Gait(ahead(4, 0.0), 3.15, BEAT_S, BEAT_S, 0.027).frames(),
    }


def both(**angles: float) -> Pose:
    """Return joints of both sides alike."""
    return {**left(**angles), **right(**angles)}


def left(**angles: float) -> Pose:
    """Return joints of the left side."""
    return {f"left_{joint}": angle for joint, angle in angles.items()}


def right(**angles: float) -> Pose:
    """Return joints of the right side."""
    return {f"right_{joint}": angle for joint, angle in angles.items()}


def _lasso(swings: Limb, folds: Limb) -> tuple[Frame, ...]:
    folded = folds(shoulder_pitch=0.5, shoulder_yaw=-0.8, elbow=-1.6)
    turns = ((1.2, -1.2, 0.01, 0.2), (1.6, -0.9, 0.0, 0.0), (2.0, -1.2, -0.01, -0.2), (1.6, -1.5, 0.0, 0.0))
    return tuple(
        frame(
            {
                **ARMS,
                **legs(sway, 0.385 if sway else 0.37),
                **swings(shoulder_pitch=0.1, shoulder_roll=1.7, shoulder_yaw=yaw, elbow=elbow),
                **folded,
                "neck_yaw": looks,
            },
            BEAT_S / 2,
        )
        for yaw, elbow, sway, looks in turns
    )


def _figure(name: str, times: int = 1) -> Frame:
    return Frame(figure=name, times=times)


def _lasting(
    name: str, total_s: float, frames: list[Frame], figures: dict[str, tuple[Frame, ...]] | None = None
) -> Programme:
    """Return frames and then the walking stance, taken in the time that is left."""
    played_s = Programme(frames=tuple(frames), figures=figures or {}).duration_s
    end = frame(BASIC, round(total_s - played_s, 3))
    return Programme(name=name, frames=(*frames, end), figures=figures or {})


def written(all_of_them: dict[int, Programme]) -> str:
    """Return the text of `firmware.json`, a frame a line, naming only servos that have something new to do."""
    return "{\n" + ",\n".join(f'  "{slot}": {_programme(each)}' for slot, each in sorted(all_of_them.items())) + "\n}\n"


def _programme(programme: Programme) -> str:
    fields = {"name": programme.name, "limp": programme.limp} if programme.limp else {"name": programme.name}
    text = json.dumps(fields)[:-1] + f', "frames": [{_lines(programme.frames, 4)}]'
    if programme.figures:
        figures = (f'\n    "{name}": [{_lines(frames, 6)}]' for name, frames in programme.figures.items())
        text += f',\n   "figures": {{{",".join(figures)}}}'
    return text + "}"


def _lines(frames: Iterable[Frame], indent: int) -> str:
    out: list[dict[str, Any]] = []
    told: dict[str, float] = {}
    for each in frames:
        counts = {servo: int(count) if count == int(count) else count for servo, count in each.counts.items()}
        new: dict[str, Any] = {"duration_s": round(each.duration_s, 6)}
        new |= {"counts": changed} if (changed := {k: v for k, v in counts.items() if told.get(k) != v}) else {}
        new |= {"smooth": True} if each.smooth else {}
        told = {} if each.figure else told | counts
        out.append({"figure": each.figure, "times": each.times} if each.figure else new)
    return ",".join(f"\n{' ' * indent}{json.dumps(line)}" for line in out)


if __name__ == "__main__":
    FILE.write_text(written(programmes()))
