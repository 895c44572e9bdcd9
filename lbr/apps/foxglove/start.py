"""The bridge, or a sentence about the missing package."""

try:
    from lbr.apps.foxglove.capability import Foxglove
except ModuleNotFoundError as err:
    raise ImportError(
        f"the Foxglove bridge needs the extra 'foxglove' ({err.name} is missing): pip install 'lbr[foxglove]'"
    ) from err

__all__ = ["Foxglove"]
