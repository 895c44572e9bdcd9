"""A D-Bus of the test's own with a scripted logind on it; the system's bus is never touched."""

import asyncio
import subprocess
import threading
from pathlib import Path

from dbus_fast import BusType, Message, MessageType
from dbus_fast.aio import MessageBus

from tests.support import needs, programs
from tests.support.waiting import HANG_S

CONFIG = """<!DOCTYPE busconfig PUBLIC "-//freedesktop//DTD D-Bus Bus Configuration 1.0//EN"
 "http://www.freedesktop.org/standards/dbus/1.0/busconfig.dtd">
<busconfig>
  <listen>unix:path={path}</listen>
  <auth>EXTERNAL</auth>
  <policy context="default"><allow send_destination="*"/><allow eavesdrop="false"/><allow own="*"/></policy>
</busconfig>
"""
needs_dbus = needs.program("dbus-daemon", "dbus-daemon")


class Logind:
    """Answers as scripted and notes every call; a thread with a loop of its own."""

    def __init__(self, place: Path) -> None:
        self.can = "yes"
        self.power_off_error = ""
        self.silent = False
        self.calls: list[tuple[str, list[object]]] = []
        config = place / "bus.conf"
        self.address = f"unix:path={place / 'bus'}"
        config.write_text(CONFIG.format(path=place / "bus"))
        words = ["dbus-daemon", f"--config-file={config}", "--nofork", "--nopidfile", "--print-address=1"]
        self._daemon = programs.start(words, stdout=subprocess.PIPE, text=True)
        assert self._daemon.stdout is not None
        assert self._daemon.stdout.readline().startswith("unix:")
        self._loop = asyncio.new_event_loop()
        self._there = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        assert self._there.wait(HANG_S)

    def finish(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()
        self._daemon.terminate()
        self._daemon.wait()
        assert self._daemon.stdout is not None
        self._daemon.stdout.close()

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        bus = self._loop.run_until_complete(self._serve())
        self._there.set()
        self._loop.run_forever()
        bus.disconnect()
        self._loop.run_until_complete(bus.wait_for_disconnect())

    async def _serve(self) -> MessageBus:
        bus = await MessageBus(bus_address=self.address, bus_type=BusType.SYSTEM).connect()
        bus.add_message_handler(self._answer)
        await bus.request_name("org.freedesktop.login1")
        return bus

    def _answer(self, message: Message) -> Message | bool | None:
        if message.message_type != MessageType.METHOD_CALL or message.interface != "org.freedesktop.login1.Manager":
            return None
        self.calls.append((message.member, message.body))
        if self.silent:
            return True
        if message.member == "CanPowerOff":
            return Message.new_method_return(message, "s", [self.can])
        if self.power_off_error:
            return Message.new_error(message, f"org.freedesktop.DBus.Error.{self.power_off_error}", "not now")
        return Message.new_method_return(message)
