"""A Raspberry Pi's own camera at `csi:N`, by picamera2 of Raspberry Pi OS.

Written from its documentation and tested with a stand-in only, not with a camera.
"""

import os
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from types import ModuleType
from typing import Any

from lbr.capability.context import Device
from lbr.drivers.camera import CameraSettings
from lbr.drivers.camera.picture import Picture, check_controls
from lbr.errors import DeviceError

HELD = 2


class CsiSource:
    """A camera whose library thread delivers JPEG pictures."""

    def __init__(self, device: Device, settings: CameraSettings) -> None:
        library, transform = _library()
        self._says = f"device '{device.name}' at {device.address}"
        self._pictures: deque[Picture] = deque(maxlen=HELD)
        self._camera: Any = None
        self._ready = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        try:
            self._camera = library.Picamera2(_number(device))
            check_controls(device, settings.controls, list(self._camera.camera_controls))
            turned = settings.rotation_deg == 180
            self._camera.configure(
                self._camera.create_video_configuration(
                    main={"size": (settings.width_px, settings.height_px)},
                    transform=transform(hflip=turned, vflip=turned),
                    controls={"FrameRate": settings.fps, **settings.controls},
                )
            )
            self._camera.start_recording(library.encoders.MJPEGEncoder(), _output(library, self._store))
        except DeviceError:
            self.close()
            raise
        except Exception as err:
            self.close()
            raise DeviceError(
                f"{self._says} cannot be opened: {err}; 'rpicam-hello --list-cameras' lists them"
            ) from err

    def fileno(self) -> int:
        """Return a descriptor that is readable once there is a picture."""
        return self._ready

    def take(self) -> list[Picture]:
        """Return the pictures received since the last call."""
        with suppress(BlockingIOError):
            os.eventfd_read(self._ready)
        pictures = []
        while self._pictures:
            pictures.append(self._pictures.popleft())
        return pictures

    def pace(self, fps: float) -> None:
        """Set the sensor's rate."""
        with suppress(Exception):
            self._camera.set_controls({"FrameRate": fps})

    def close(self) -> None:
        """Stop recording and close the camera."""
        camera, self._camera = self._camera, None
        if camera is not None:
            with suppress(Exception):
                camera.stop_recording()
            with suppress(Exception):
                camera.close()
        ready, self._ready = self._ready, -1
        if ready >= 0:
            os.close(ready)

    def _store(self, data: bytes) -> None:
        self._pictures.append(Picture(bytes(data), time.monotonic()))
        with suppress(OSError):  # closed in between
            os.eventfd_write(self._ready, 1)


def _library() -> tuple[ModuleType, type]:
    try:
        import libcamera  # type: ignore[import-not-found, unused-ignore]
        import picamera2.encoders  # type: ignore[import-not-found, unused-ignore]
        import picamera2.outputs  # type: ignore[import-not-found, unused-ignore]
    except ImportError as err:
        raise DeviceError(
            "a camera at csi:N needs picamera2: apt install python3-picamera2 on Raspberry Pi OS, "
            "and a virtual environment made with --system-site-packages"
        ) from err
    return picamera2, libcamera.Transform


def _number(device: Device) -> int:
    number = device.address.removeprefix("csi:")
    if not number.isdecimal():
        raise DeviceError(f"device '{device.name}': '{device.address}' names no camera; the first is csi:0")
    return int(number)


def _output(library: Any, store: Callable[[bytes], None]) -> object:
    class Slot(library.outputs.Output):  # type: ignore[misc] # its class is known at run time only
        def outputframe(self, frame: bytes, *_rest: object, **_named: object) -> None:
            store(frame)

    return Slot()
