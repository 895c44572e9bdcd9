"""Serial lines of the kernel's own drivers: who they are by name, busy, slow, in pieces, pulled out, swapped."""

import time
from dataclasses import replace
from pathlib import Path

import pytest

from lbr.capability.context import Device
from lbr.drivers.echoed_lines import query
from lbr.drivers.serial_line import open_line
from lbr.errors import DeviceError
from tests.support.usb.rig import ARDUINO, FT232R, ROBOTEQ, CdcAcm, Ftdi, by_id, on_line, until

pytestmark = pytest.mark.usefixtures("played")
FIRMWARE = query("FID")


def row(address: Path | str) -> Device:
    return Device("motor_controller", "roboteq", str(address), {})


def asked(line, question: bytes = FIRMWARE, within_s: float = 5.0) -> bytes:
    line.drop_input()
    line.write(question)
    heard, end = b"", time.monotonic() + within_s
    while b"Roboteq" not in heard and time.monotonic() < end:
        heard += line.read(0.1)
    return heard


def told_of_the_cable(line) -> float:
    """Read until the line says that it went away; return when."""
    with pytest.raises(DeviceError, match="went away"):
        until(lambda: line.read(0.05) and False, "told")
    return time.monotonic()


def test_a_motor_controller_has_the_name_of_the_shipped_row_and_says_who_it_is(tmp_path, record_property):
    with on_line("roboteq", tmp_path, CdcAcm, ROBOTEQ) as rig:
        assert by_id(ROBOTEQ) == Path("/dev/serial/by-id/usb-Roboteq_Motor_Controller-if00")
        line = open_line(row(by_id(ROBOTEQ)), 115_200)
        try:
            assert b"Roboteq" in asked(line)
            assert rig.function.baud == 115_200
            with pytest.raises(DeviceError, match="is busy: held by"):
                open_line(row(by_id(ROBOTEQ)), 115_200)
            pulled = rig.cable.unplug()
            told_s = told_of_the_cable(line) - pulled
            record_property("told of the cable by the kernel after ms", round(told_s * 1e3))
        finally:
            line.close()
        with pytest.raises(DeviceError, match="is missing"):
            open_line(row(by_id(ROBOTEQ)), 115_200)
        rig.cable.plug()
        record_property("named again after s", round(until(by_id(ROBOTEQ).exists, "its name", 60.0), 2))
        line = open_line(row(by_id(ROBOTEQ)), 115_200)
        assert b"Roboteq" in asked(line)
        line.close()


@pytest.mark.parametrize(("piece", "pause_s"), [(1, 0.0), (3, 0.02)])
def test_an_answer_in_pieces_and_late_is_read_whole(tmp_path, piece, pause_s):
    with on_line("roboteq", tmp_path, CdcAcm, ROBOTEQ) as rig:
        rig.function.piece, rig.function.pause_s = piece, pause_s
        line = open_line(row(by_id(ROBOTEQ)), 115_200)
        found = asked(line, within_s=20.0)
        line.close()
        assert b"Roboteq" in found


def test_an_ftdi_adaptor_waits_for_one_millisecond_and_not_sixteen(tmp_path):
    with on_line("roboteq", tmp_path, Ftdi, FT232R) as rig:
        line = open_line(row(by_id(FT232R)), 115_200)
        line.low_latency()
        assert b"Roboteq" in asked(line, within_s=20.0)
        assert rig.function.baud == 115_200
        line.close()
        assert rig.function.asked_latency_ms[-1] == 1
        assert (
            Path("/sys/class/tty") / by_id(FT232R).resolve().name / "device/latency_timer"
        ).read_text().strip() == "1"


def test_two_alike_keep_their_names_when_they_come_back_in_the_other_order(tmp_path):
    first, second = (replace(ARDUINO, serial=number) for number in ("LEFT", "RIGHT"))
    with on_line("roboteq", tmp_path, CdcAcm, first) as left, on_line("roboteq", tmp_path, CdcAcm, second) as right:
        before = by_id(first).resolve(), by_id(second).resolve()
        for rig in (left, right):
            rig.cable.unplug()
        until(lambda: not by_id(first).exists() and not by_id(second).exists(), "the old names gone", 60.0)
        right.cable.plug()
        until(by_id(second).exists, "the second's name", 60.0)
        left.cable.plug()
        until(by_id(first).exists, "the first's name", 60.0)
        assert (by_id(second).resolve(), by_id(first).resolve()) == before, "the numbers are swapped"
        left.twin.fault("silent")
        for identity, answers in ((first, False), (second, True)):
            line = open_line(row(by_id(identity)), 115_200)
            assert (b"Roboteq" in asked(line, within_s=20.0 if answers else 1.0)) == answers
            line.close()


def test_a_line_is_found_by_ids_and_serial_number(tmp_path):
    with on_line("roboteq", tmp_path, CdcAcm, ARDUINO):
        line = open_line(row(f"usb:2341:0043:{ARDUINO.serial}"), 115_200)
        assert line.path == str(by_id(ARDUINO).resolve())
        line.close()
        with pytest.raises(DeviceError, match="nothing matches"):
            open_line(row("usb:2341:0043:OTHER"), 115_200)
