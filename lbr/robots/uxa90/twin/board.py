"""The emulated main board (UIC): its modes, its motions, and the servos to which it passes packets on.

In normal mode it obeys only its own frames. A frame of type 0x10 takes PC control: from then on servo packets are
passed on, except while a motion plays. The effect of a packet on a servo is computed when the packet is handed in, a
little early.
"""

from collections.abc import Iterable, Mapping
from typing import Literal

from lbr.robots.uxa90.twin import Uxa90Faults, Uxa90Row
from lbr.robots.uxa90.twin.firmware import Player, Programme, shipped
from lbr.robots.uxa90.twin.packets import Frame, Packet, Reader, framed
from lbr.robots.uxa90.twin.replies import Replies
from lbr.robots.uxa90.twin.servo import MIDDLE, SamServo
from lbr.robots.uxa90.twin.servobus import ServoLine
from lbr.simulation.measured import ImuReading, ServoDrive, ServoFelt

Mode = Literal["off", "normal", "pc"]

CONTROL, REMOTE, SERIAL, FIRMWARE, ZEROS, SET_ZEROS, IMU, LAST_BUTTON = 0x10, 0x14, 0x0C, 0x12, 0x0B, 0x0E, 0x1A, 0x19
POWER_OFF = 33
SITTING = 21
LEAST_SUPPLY_V = 9.0
"""The voltage below which its processors are off."""

KILLED_S = 0.5
_PLAY, _LEAVE = 0xE1, 0xFB
_PLATFORM = 4
_G_MPS2 = 9.80665


class MainBoard:
    """A robot from power-up on, sitting and limp; `now` is the time at each call and never goes back."""

    def __init__(self, row: Uxa90Row | None = None, *, seed: int = 0) -> None:
        self.row = row or Uxa90Row()
        self.programmes: Mapping[int, Programme] = {
            **shipped(),
            **{int(slot): programme for slot, programme in self.row.programmes.items()},
        }
        self.zeros = bytearray(self.row.zeros)
        self.servos = tuple(self._servo(number) for number in self.row.ids)
        self.imu = ImuReading()
        self.playing: int | None = None
        self.last_button = 0
        self._faults = self.row.faults
        self._byte_s = 10.0 / self.row.baud
        self._reader = Reader()
        self._replies = Replies(self._faults, seed, self._byte_s)
        self._line = ServoLine(self.row, self.servos, self._replies)
        self._player: Player | None = None
        self._by_remote = False
        self.mode: Mode = "normal"
        self._taken_at: float | None = None
        self._since = 0.0
        self._host_free = 0.0
        self._supplied, self._off = True, False
        self.faults = self._faults

    @property
    def faults(self) -> Uxa90Faults:
        """Return its faults; setting them takes effect at once."""
        return self._faults

    @faults.setter
    def faults(self, faults: Uxa90Faults) -> None:
        self._faults = self._replies.faults = faults
        if faults.brown_out:
            self._off = False
        self._power(on=self._supplied and not faults.brown_out and not self._off)
        for servo in self.servos:
            servo.suffer(stuck=servo.number in faults.stuck, frozen=faults.frozen)

    # The line.

    def feed(self, data: bytes, now: float, baud: float | None = None) -> bytes:
        """Receive bytes that the host sends at a rate; return the bytes that have reached the host so far."""
        answers = self.poll(now)
        if self.mode == "off" or (baud and abs(baud - self.row.baud) > 0.03 * self.row.baud):
            return answers
        begin = max(now, self._host_free)
        self._host_free = begin + len(data) * self._byte_s
        for packet in self._reader.feed(data, now):
            at = begin + max(0, packet.end) * self._byte_s
            self._until(at)
            if not packet.sound:
                continue
            if isinstance(packet, Frame):
                self._obey(packet, at)
            else:
                self._pass_on(packet, at)
        return answers + self.poll(now)

    def poll(self, now: float) -> bytes:
        """Return the bytes that have reached the host so far."""
        self._until(now)
        return self._replies.due(now) if self.mode != "off" else b""

    def next_due(self) -> float | None:
        """Return the time of its next output or action."""
        if self.mode == "off":
            return None
        played = self._player.next_at if self._player is not None else None
        given = (self._replies.next_due(), played, self._taken_at, self._killed_at())
        return min((at for at in given if at is not None), default=None)

    # The body.

    def drives(self, now: float) -> dict[int, ServoDrive]:
        """Return the state of each servo's motor now."""
        self._until(now)
        return {servo.number: servo.drive() for servo in self.servos}

    def feel(self, felt: Mapping[int, ServoFelt], supply_v: float, now: float) -> None:
        """Set the servos' positions in the world, and the voltage of their supply."""
        for servo in self.servos:
            if servo.number in felt:
                servo.feel(felt[servo.number], now)
        if (supply_v >= LEAST_SUPPLY_V) != self._supplied:
            self._supplied = not self._supplied
            self._off = False
            self.faults = self._faults

    def press(self, slot: int, now: float) -> bool:
        """Press a button of the remote control; return whether it begins a motion."""
        self._until(now)
        if self.mode == "off" or self.playing is not None:
            return False
        self.last_button, self.mode, self._taken_at = slot, "normal", None
        if slot == POWER_OFF:
            self._off = True
            self._power(on=False)
        return self._play(slot, now, by_remote=True)

    # Its own frames.

    def _obey(self, frame: Frame, at: float) -> None:
        answers = {
            FIRMWARE: bytes(self.row.firmware),
            SERIAL: self.row.serial.encode(),
            ZEROS: bytes(self.zeros),
            IMU: self._accelerations(),
            LAST_BUTTON: bytes((self.last_button, 0)),
        }
        if frame.type == CONTROL:
            self._take_control(at)
        elif frame.type == REMOTE and len(frame.contents) == 1:
            self._remote(frame.contents[0], at)
        elif frame.type == SET_ZEROS and len(frame.contents) == len(self.zeros):
            self._set_zeros(frame.contents)
        elif frame.type in answers:
            data = framed(frame.type, frame.platform if frame.type == FIRMWARE else _PLATFORM, answers[frame.type])
            broken = frame.type == IMU and not self.row.imu_sum
            self._replies.frame(data[:-1] + bytes((data[-1] ^ 0x5A,)) if broken else data, at)

    def _take_control(self, at: float) -> None:
        if self.playing is not None:
            if not self.row.aborts:
                return
            self._stop_playing()
            for servo in self.servos:
                servo.hold()
        self._taken_at = at + self.row.settle_ms * 1e-3

    def _remote(self, slot: int, at: float) -> None:
        if self.playing is None and not self.press(slot, at) and self.mode != "off":
            self._report(slot, at)

    def _report(self, slot: int, at: float) -> None:
        if self.row.reports_end:
            self._replies.frame(framed(REMOTE, _PLATFORM, bytes((slot,))), at)

    def _set_zeros(self, zeros: bytes) -> None:
        self.zeros[:] = zeros
        for servo in self.servos:
            servo.zero = zeros[servo.number]

    def _accelerations(self) -> bytes:
        lsb = (round(part / _G_MPS2 * self.row.imu_lsb_per_g) for part in self.imu.accel_mps2)
        return b"".join(max(-32768, min(32767, value)).to_bytes(2, signed=True) for value in lsb)

    # Packets for servos.

    def _pass_on(self, packet: Packet, at: float) -> None:
        if self.mode != "pc" or self.playing is not None:
            return
        data = packet.data
        if data[:2] == bytes((0xE0, _PLAY)):
            self._play(data[3], at, by_remote=False)
        elif data[:2] == bytes((0xE0, _LEAVE)):
            self.mode = "normal"
        else:
            self._line.take(packet, at)

    # Motions.

    def _play(self, slot: int, at: float, *, by_remote: bool) -> bool:
        programme = self.programmes.get(slot)
        if programme is None or self.mode == "off":
            return False
        self.playing, self._by_remote = slot, by_remote
        self._player = Player(programme, {servo.number: servo.counts for servo in self.servos}, at)
        self._until(at)
        return True

    def _stop_playing(self) -> None:
        self.playing = self._player = None

    def _until(self, now: float) -> None:
        """Do everything that is due until now."""
        while self._player is not None and self._player.next_at <= now:
            self._on_the_way(self._player)
        if self._taken_at is not None and self._taken_at <= now:
            self.mode, at = "pc", self._taken_at
            self._taken_at, self._since = None, at
            self._replies.frame(framed(CONTROL, _PLATFORM, b"\x01"), at)
        killed = self._killed_at()
        if killed is not None and killed <= now:
            self.mode = "normal"
        for servo in self.servos:
            servo.advance(now)

    def _on_the_way(self, player: Player) -> None:
        at = player.next_at
        for servo in self.servos:
            servo.advance(at)
        if not player.over:
            way = player.step()
            for servo in self.servos:
                if servo.number in way.counts:
                    servo.move(way.counts[servo.number], way.level, way.duration_s)
            return
        slot = self.playing or 0
        self._stop_playing()
        if player.programme.limp:
            for servo in self.servos:
                servo.release()
        if self._by_remote:
            self._report(slot, at)

    # Power.

    def _power(self, *, on: bool) -> None:
        if on == (self.mode != "off"):
            self._power_servos(self.servos, on=on)
            return
        self.mode, self._taken_at, self.last_button = "normal" if on else "off", None, 0
        self._stop_playing()
        self._reader.forget()
        self._replies.clear()
        self._power_servos(self.servos, on=on)

    def _power_servos(self, servos: Iterable[SamServo], *, on: bool) -> None:
        for servo in servos:
            servo.power(on=on and servo.number not in self._faults.dead)

    def _killed_at(self) -> float | None:
        return self._since + KILLED_S if self.mode == "pc" and self._faults.kills_pc else None

    def _servo(self, number: int) -> SamServo:
        sits = self.programmes[SITTING].ends_at() if SITTING in self.programmes else {}
        return SamServo(number, counts=sits.get(number, MIDDLE), zero=self.zeros[number])
