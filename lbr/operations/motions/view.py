"""The public state of the motions."""

from lbr.messages.joints import MotionsState
from lbr.operations.motions.state import State


def motions_state(state: State) -> MotionsState:
    """Return the published state."""
    lease = state.lease
    if lease is None or lease.motion.asked:
        return MotionsState(playing=False, reason=state.leases.reason.text, code=state.leases.reason.code)
    playing = lease.motion
    place = playing.programme.place(playing.passed)
    return MotionsState(
        playing=True,
        motion=place.motion,
        frame=place.frame,
        frames=place.frames,
        round=place.round,
        times=playing.programme.times,
        left_s=round(max(0.0, playing.programme.duration_s - (state.clock - playing.started)), 1),
        holder=lease.source,
    )
