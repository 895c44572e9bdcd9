"""The bridge, or the sentence that says what it lacks."""

try:
    from lbr.apps.foxglove.capability import Foxglove
except ModuleNotFoundError as err:
    raise ImportError(
        f"the Foxglove bridge needs the extra 'foxglove' ({err.name} is missing): pip install 'lbr[foxglove]'"
    ) from err

__all__ = ["Foxglove"]
