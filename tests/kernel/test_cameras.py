"""Cameras of the kernel: MJPEG of `uvcvideo` as it is sent, a cable pulled while it streams, and `vivid`, which has no MJPEG."""

import io
import time
from pathlib import Path

import pytest

from lbr.capability.context import Device
from lbr.drivers.camera import CameraSettings
from lbr.drivers.camera.v4l2 import V4l2Source
from lbr.errors import DeviceError
from tests.support import programs
from tests.support.usb import vhci
from tests.support.usb.descriptors import Identity
from tests.support.usb.device import Played
from tests.support.usb.rig import until
from tests.support.usb.uvc_function import Camera

WEBCAM = Identity(0x046D, 0x0825, "Example", "Webcam", "1234", device_class=(0xEF, 2, 1))
NODE = Path("/dev/v4l/by-id/usb-Example_Webcam_1234-video-index0")
VIDEO = Path("/sys/class/video4linux")
ONE_THAT_CAPTURES = ("n_devs=1", "node_types=0x1")


def picture(width, height, number):
    image = pytest.importorskip("PIL.Image")
    found = io.BytesIO()
    image.new("RGB", (width, height), (number % 256, 80, 40)).save(found, "JPEG")
    return found.getvalue()


def test_pictures_come_brightness_arrives_and_a_pulled_cable_is_told(played, record_property):
    if why := vhci.why_no_module("uvcvideo"):
        pytest.skip(why)
    pytest.importorskip("linuxpy")
    pictures = {size: picture(*size, 1) for size in ((640, 480), (640, 360), (320, 240))}
    function = Camera(lambda width, height, number: pictures[width, height], WEBCAM)
    with Played(function) as cable:
        until(NODE.exists, f"a name for the camera: {NODE}", 120.0)
        row = Device("front_camera", "camera", str(NODE), {})
        with pytest.raises(DeviceError, match="warp"):
            V4l2Source(row, CameraSettings(device="front_camera", controls={"warp": 1}))
        source = V4l2Source(row, CameraSettings(device="front_camera", controls={"brightness": 20}))
        taken = []
        began = time.monotonic()
        until(lambda: taken.extend(source.take()) or len(taken) >= 10, "ten pictures", 120.0)
        record_property("pictures a second", round(len(taken) / (time.monotonic() - began), 1))
        assert {one.data for one in taken if one.data} == {pictures[640, 360]}
        assert function.brightness == 20
        cable.unplug()
        with pytest.raises(DeviceError, match=r"went away|missing"):
            until(lambda: source.take() and False, "told", 30.0)
        source.close()


@pytest.fixture
def raw_camera():
    """The node of a camera of the kernel's own that has raw formats alone."""

    def nodes():
        found = VIDEO.glob("video*/name") if VIDEO.exists() else ()
        return [Path("/dev", one.parent.name) for one in found if one.read_text().startswith("vivid")]

    if why := vhci.why_no_module("vivid", *ONE_THAT_CAPTURES):
        pytest.skip(why)
    try:
        until(lambda: nodes() and nodes()[0].exists(), "a camera of vivid", 120.0)
        yield nodes()[0]
    finally:
        programs.run(["modprobe", "-r", "vivid"], check=False)


def test_a_camera_without_mjpeg_is_refused_with_what_it_sends(raw_camera, record_property):
    pytest.importorskip("linuxpy")
    row = Device("front_camera", "camera", str(raw_camera), {})
    with pytest.raises(DeviceError, match=r"device 'front_camera' at /dev/video\d+ sends \w+ and no MJPG") as told:
        V4l2Source(row, CameraSettings(device="front_camera"))
    record_property("told", str(told.value))
