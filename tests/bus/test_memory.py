"""The bus in memory answers as the one between processes does."""

from lbr.bus.memory import Memory, MemoryTransport


def test_an_output_of_pictures_is_watched_while_somebody_receives_it_and_any_other_always():
    bus = MemoryTransport(Memory())
    state = bus.publisher("r/drive/state", "drive")
    pictures = bus.publisher("r/camera/frame", "camera", watching=lambda: None)
    assert (state.watched, pictures.watched) == (True, False)
    viewer = bus.subscribe("r/camera/frame", depth=1, wake=None)
    assert pictures.watched
    viewer.close()
    assert not pictures.watched
