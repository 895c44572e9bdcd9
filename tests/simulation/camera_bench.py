"""A client of an emulated camera, and how its pictures are looked at."""

import io
import json
import socket
import struct

import numpy as np
from PIL import Image

from tests.support.waiting import HANG_S


def like(pixel, colour):
    """The same hue, whatever the light."""
    return all(abs(a / max(pixel) - b / max(colour)) < 0.12 for a, b in zip(pixel, colour, strict=True))


def picture(jpeg):
    return Image.open(io.BytesIO(jpeg)).convert("RGB")


def orange(jpeg):
    """Where the ball is in a picture: shares of its width and height from the middle, and how much of it it takes."""
    red, green, blue = np.asarray(picture(jpeg), float).transpose(2, 0, 1)
    seen = (red > 1.5 * green) & (green > 1.5 * blue) & (red > 80)
    if not seen.any():
        return None
    down, across = np.argwhere(seen).mean(axis=0) / seen.shape
    return across - 0.5, down - 0.5, seen.mean()


class Film:
    """A client of a camera's socket."""

    def __init__(self, path, **wanted):
        self.connection = socket.socket(socket.AF_UNIX)
        self.connection.settimeout(HANG_S)
        self.connection.connect(str(path))
        self.stream = self.connection.makefile("rb")
        if wanted:
            self.ask(**wanted)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stream.close()
        self.connection.close()

    def ask(self, **wanted):
        self.connection.sendall(json.dumps(wanted).encode() + b"\n")

    def frame(self):
        """The next picture and when it was taken; None at the end."""
        try:
            header = self.stream.read(12)
            if len(header) < 12:
                return None
            length, taken_ns = struct.unpack("<IQ", header)
            return self.stream.read(length), taken_ns
        except ConnectionError:
            return None
