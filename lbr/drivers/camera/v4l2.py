"""A camera at /dev/videoN or /dev/v4l/by-id/NAME, by linuxpy: its MJPEG unchanged, cut to the bytes used."""

import errno
import os
import select
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

from lbr.capability.context import Device
from lbr.drivers import access
from lbr.drivers.camera import CameraSettings
from lbr.drivers.camera.picture import Picture, check_controls
from lbr.errors import DeviceError

PIXEL_FORMAT = "MJPG"
JPEG_FORMATS = {"MJPG", "JPEG"}
MONOTONIC = 0x2000  # V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC
BROKEN = 0x0040  # V4L2_BUF_FLAG_ERROR: the driver marks the picture as incomplete
BUFFERS = 2
TRUSTED_AGE_S = 1.0


class V4l2Source:
    """An open camera that streams."""

    def __init__(self, device: Device, settings: CameraSettings) -> None:
        video = _library()
        self._row = device
        self._says = f"device '{device.name}' at {device.address}"
        self._camera = video.Device(device.address)
        self._capture: Any = None
        with ExitStack() as failed:
            failed.callback(self.close)
            with self._telling("cannot be opened"):
                self._camera.open()
            self._capture = video.VideoCapture(self._camera, size=BUFFERS)
            with self._telling("cannot be set up"):
                self._set_up(settings)
                self._capture.open()
            failed.pop_all()

    def fileno(self) -> int:
        """Return the device's descriptor."""
        fileno: int = self._camera.fileno()
        return fileno

    def take(self) -> list[Picture]:
        """Return the pictures in the driver's buffers."""
        pictures: list[Picture] = []
        with self._telling("went away"):
            while len(pictures) <= BUFFERS and select.select([self.fileno()], [], [], 0)[0]:
                try:
                    frame = self._capture.buffer.raw_read()
                except BlockingIOError:
                    break
                pictures.append(_picture(frame))
        return pictures

    def pace(self, fps: float) -> None:
        """Do nothing: the device would have to stop for that, and the next picture would be late."""

    def close(self) -> None:
        """Stop the stream and close the device."""
        capture, self._capture = self._capture, None
        if capture is not None:
            with suppress(Exception):  # unplugged: a stream that cannot be stopped is already over
                capture.close()
        with suppress(Exception):
            self._camera.close()

    def _set_up(self, settings: CameraSettings) -> None:
        capture = self._capture
        capture.set_format(settings.width_px, settings.height_px, PIXEL_FORMAT)
        given = capture.get_format().pixel_format.human_str()
        if given not in JPEG_FORMATS:
            raise DeviceError(f"{self._says} sends {given} and no {PIXEL_FORMAT}: lbr passes JPEG on and encodes none")
        capture.set_fps(settings.fps)
        self._camera.controls.set_clipping(False)  # a value out of bounds is refused, not clipped
        controls = {control.config_name: control for control in self._camera.controls.values()}
        check_controls(self._row, settings.controls, list(controls))
        for name, value in settings.controls.items():  # in the row's order: manual exposure before its time
            try:
                controls[name].value = int(value)
            except (AttributeError, ValueError, OSError) as err:
                raise DeviceError(f"{self._says} does not take {value} for its control {name}: {err}") from err

    @contextmanager
    def _telling(self, trouble: str) -> Iterator[None]:
        try:
            yield
        except DeviceError:
            raise
        except OSError as err:
            raise DeviceError(
                f"{self._says} {_sentence(err, trouble, self._row.address)}", access.code_of(err)
            ) from err
        except Exception as err:  # the library has errors of its own
            raise DeviceError(f"{self._says} {trouble}: {err}") from err


def _library() -> Any:
    try:
        from linuxpy.video import device  # type: ignore[import-untyped]
    except ImportError as err:
        raise DeviceError("a camera at /dev needs the extra 'camera': pip install 'lbr[camera]'") from err
    return device


def _picture(frame: Any) -> Picture:
    now = time.monotonic()
    flags = int(frame.buff.flags)
    if flags & BROKEN:
        return Picture(b"", now)
    taken = float(frame.timestamp) if flags & MONOTONIC else now
    return Picture(bytes(frame.data)[: frame.nbytes], taken if 0.0 <= now - taken <= TRUSTED_AGE_S else now)


def _sentence(err: OSError, trouble: str, path: str) -> str:
    match err.errno:
        case errno.ENOENT | errno.ENXIO | errno.ENODEV:
            return "is missing; plug it in, or correct the address in the device row"
        case errno.EACCES | errno.EPERM:
            return access.refused(path, "video")
        case errno.EBUSY:
            return "is busy; stop the other program that uses it (fuser -v names it)"
        case _:
            cause = os.strerror(err.errno) if err.errno else str(err)
            return f"{trouble} ({cause}); check its cable"
