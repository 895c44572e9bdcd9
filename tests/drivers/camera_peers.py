"""Cameras for tests: pictures on a real socket, and stand-ins for the two libraries at the surface that lbr uses."""

import errno
import os
import socket
import struct
import sys
import threading
import time
from collections import deque
from contextlib import suppress
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar

from lbr.drivers.camera import KIND
from tests.drivers.peers import DriverContext


def jpeg(mark: int = 0, width: int = 640, height: int = 360, size: int = 400) -> bytes:
    """A picture as far as anybody looks who does not decode it."""
    header = b"\xff\xc0" + struct.pack(">HBHHB", 8, 8, height, width, 0)
    body = b"\xff\xe0\x00\x04\x00\x00" + header + b"\xff\xda" + struct.pack("<I", mark) + b"\x01" * size
    return b"\xff\xd8" + body + b"\xff\xd9"


class PictureSocket:
    """A program that sends pictures to whoever connects, when the test says so."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.heard = b""
        self.client: socket.socket | None = None
        self.clients = 0
        self._plug()

    def send(self, data: bytes, *, age_s: float = 0.0) -> float:
        """Send a picture, and return when it was taken."""
        taken_ns = time.monotonic_ns() - int(age_s * 1e9)
        self.send_raw(struct.pack("<IQ", len(data), taken_ns) + data)
        return taken_ns / 1e9

    def send_raw(self, data: bytes) -> None:
        assert self.client is not None
        self.client.sendall(data)

    @property
    def connected(self) -> bool:
        """Whether a client is there and has not hung up."""
        if self.client is None:
            return False
        try:
            while data := self.client.recv(65536, socket.MSG_DONTWAIT):
                self.heard += data
        except BlockingIOError:
            return True
        except OSError:
            return False
        return False

    def unplug(self) -> None:
        self._listener.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._listener.close()
        self.path.unlink(missing_ok=True)
        if self.client is not None:
            self.client.close()
            self.client = None

    def replug(self) -> None:
        self._plug()

    def close(self) -> None:
        if self.path.exists():
            self.unplug()

    def _plug(self) -> None:
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(self.path))
        self._listener.listen()
        self._thread = threading.Thread(target=self._accept, daemon=True)
        self._thread.start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                if self.client is not None:
                    self.client.close()
                self.client, self.clients = client, self.clients + 1


class CameraContext(DriverContext):
    """A camera's context: `woken` is an event that other threads set."""

    def __init__(self, settings: Any, address: str, home: Path) -> None:
        super().__init__(KIND, settings, address, "camera")
        self.name = "camera_front"
        self.home = str(home)
        self.woken = threading.Event()

    def wake(self) -> None:
        self.woken.set()

    @property
    def frames(self) -> list[bytes]:
        return [message.data for output, message in self.published if output == "frame"]

    @property
    def state(self) -> Any:
        return next(message for output, message in reversed(self.published) if output == "state")


MONOTONIC, ERROR = 0x2000, 0x0040


class Webcam:
    """What stands behind a stand-in for linuxpy: one camera, its controls, and the buffers that it has filled."""

    def __init__(self) -> None:
        self.present = True
        self.opened = 0
        self.pixel_format = "MJPG"
        self.asked: list[Any] = []
        self.controls = dict.fromkeys(("brightness", "power_line_frequency", "auto_exposure"), 0)
        self.inactive: set[str] = set()
        self._filled: deque[tuple[bytes, int, int, float]] = deque()
        self._ready, self._fill = os.pipe2(os.O_NONBLOCK)

    def fill(self, data: bytes, *, junk: bytes = b"", flags: int = MONOTONIC, age_s: float = 0.0) -> None:
        """Fill a buffer: `junk` is what an older, larger picture left behind in it."""
        self._filled.append((data + junk, len(data), flags, time.monotonic() - age_s))
        os.write(self._fill, b"x")

    def unplug(self) -> None:
        self.present = False
        os.write(self._fill, b"x")

    def close(self) -> None:
        os.close(self._ready)
        os.close(self._fill)

    def module(self) -> ModuleType:  # noqa: C901 - three small classes around one camera
        """Return what `linuxpy.video.device` is to lbr."""
        camera = self

        class Control:
            def __init__(self, name: str) -> None:
                self.config_name = name

            def __setattr__(self, key: str, value: Any) -> None:
                if key == "value":
                    if self.config_name in camera.inactive:
                        raise AttributeError(f"IntegerControl {self.config_name} is not writeable: inactive")
                    camera.controls[self.config_name] = value
                else:
                    super().__setattr__(key, value)

        class Controls(dict[int, Control]):
            def set_clipping(self, clipping: bool) -> None:
                camera.asked.append(f"clipping {clipping}")

        class Device:
            def __init__(self, path: str) -> None:
                self.path = path

            def open(self) -> None:
                if not camera.present:
                    raise FileNotFoundError(errno.ENOENT, "No such file or directory", self.path)
                camera.opened += 1
                self.controls = Controls(enumerate(map(Control, camera.controls)))

            def fileno(self) -> int:
                return camera._ready

            def close(self) -> None:
                if hasattr(self, "controls"):
                    camera.opened -= 1
                    del self.controls

        class VideoCapture:
            def __init__(self, device: Device, size: int) -> None:
                self.buffer = SimpleNamespace(raw_read=self._read)

            def set_format(self, width: int, height: int, pixel_format: str) -> None:
                camera.asked.append((width, height, pixel_format))

            def get_format(self) -> Any:
                return SimpleNamespace(pixel_format=SimpleNamespace(human_str=lambda: camera.pixel_format))

            def set_fps(self, fps: int) -> None:
                camera.asked.append(fps)

            def open(self) -> None:
                camera.asked.append("stream on")

            def close(self) -> None:
                if not camera.present:
                    raise OSError(errno.ENODEV, "No such device")
                camera.asked.append("stream off")

            def _read(self) -> Any:
                os.read(camera._ready, 1)
                if not camera.present:
                    raise OSError(errno.ENODEV, "No such device")
                data, used, flags, taken = camera._filled.popleft()
                return SimpleNamespace(
                    data=data, nbytes=used, timestamp=taken, buff=SimpleNamespace(flags=flags, bytesused=used)
                )

        module = ModuleType("linuxpy.video.device")
        module.Device, module.VideoCapture = Device, VideoCapture  # type: ignore[attr-defined]
        return module

    def install(self, monkeypatch: Any) -> None:
        package, video, device = ModuleType("linuxpy"), ModuleType("linuxpy.video"), self.module()
        package.video, video.device = video, device  # type: ignore[attr-defined]
        for name, module in (("linuxpy", package), ("linuxpy.video", video), ("linuxpy.video.device", device)):
            monkeypatch.setitem(sys.modules, name, module)


class PiCamera:
    """A stand-in for picamera2 that records what it was told, and hands over what the test gives."""

    def __init__(self) -> None:
        self.asked: list[Any] = []
        self.output: Any = None

    def install(self, monkeypatch: Any) -> None:
        camera = self

        class Picamera2:
            camera_controls: ClassVar = {"Brightness": (-1, 1, 0), "AwbEnable": (False, True, True)}

            def __init__(self, number: int) -> None:
                camera.asked.append(number)

            def create_video_configuration(self, **wanted: Any) -> Any:
                return wanted

            def configure(self, configuration: Any) -> None:
                camera.asked.append(configuration)

            def start_recording(self, encoder: Any, output: Any) -> None:
                camera.output = output

            def stop_recording(self) -> None:
                camera.asked.append("stopped")

            def close(self) -> None:
                camera.asked.append("closed")

        class Output:
            pass

        library = ModuleType("picamera2")
        library.Picamera2 = Picamera2  # type: ignore[attr-defined]
        library.encoders = ModuleType("picamera2.encoders")  # type: ignore[attr-defined]
        library.encoders.MJPEGEncoder = object  # type: ignore[attr-defined]
        library.outputs = ModuleType("picamera2.outputs")  # type: ignore[attr-defined]
        library.outputs.Output = Output  # type: ignore[attr-defined]
        system = ModuleType("libcamera")
        system.Transform = lambda **turned: turned  # type: ignore[attr-defined]
        for module in (library, library.encoders, library.outputs, system):  # type: ignore[attr-defined]
            monkeypatch.setitem(sys.modules, module.__name__, module)
