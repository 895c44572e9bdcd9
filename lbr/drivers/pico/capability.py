"""The UPS PIco as a capability: one register at each tick, a state after each sweep, and the relay of the motors."""

from msgspec.structs import replace

from lbr.capability.base import Capability
from lbr.capability.context import Call, Context
from lbr.drivers.i2c import open_bus
from lbr.drivers.inertial import Notices
from lbr.drivers.pico import PicoSettings
from lbr.drivers.pico.registers import STATUS_ADDRESS
from lbr.drivers.pico.supply import Supply
from lbr.messages.leases import CommandReply
from lbr.messages.power import RelayCommand, UpsState


class Pico(Capability[PicoSettings]):
    """Publishes the power source about once a second, invalid with a reason if it is unknown."""

    def __init__(self, ctx: Context[PicoSettings]) -> None:
        super().__init__(ctx)
        self.rate_hz = 1.0 / ctx.settings.pace_s
        self._notices = Notices(ctx)
        self._supply: Supply | None = None
        self._trouble = ""

    def open(self) -> None:
        """Open the bus; the first second shows whether the supply answers."""
        device = self.device_row
        bus, address = open_bus(device, STATUS_ADDRESS)
        self._supply = Supply(bus, address, device, self.ctx.settings, self.ctx.clock)
        self._trouble = ""

    def step(self) -> None:
        """Do one exchange."""
        assert self._supply is not None
        if not self.ctx.on_tick:
            return
        state = self._supply.exchange()
        if state is not None:
            self._tell(state)

    def command(self, call: Call) -> None:
        """Switch the relay, and reply once it was read back."""
        if not isinstance(call.message, RelayCommand) or self._supply is None:
            super().command(call)
            return
        on = call.message.on
        word = "on" if on else "off"

        def answer(trouble: str) -> None:
            if trouble:
                call.refuse(trouble, "failed")
            else:
                self.ctx.event("relay", f"{call.source} switched the motors' power {word}", about=call.source)
                call.reply(CommandReply(accepted=True, reason=f"the motors' power is {word}"))

        self._supply.switch(answer, on=on)

    def degraded(self, reason: str) -> None:
        """Publish that nothing is known."""
        self._publish(UpsState(valid=False, reason=reason, code="unreachable"))

    def close(self) -> None:
        """Close the bus; the relay stays as it is."""
        supply, self._supply = self._supply, None
        if supply is not None:
            supply.close()

    def _tell(self, state: UpsState) -> None:
        self._publish(state)
        trouble = state.reason
        if bool(trouble) != bool(self._trouble):
            told = f"device '{self.ctx.settings.device}': {trouble}"
            self.ctx.warn(told, "unreachable") if trouble else self.ctx.ready()
        elif trouble not in {"", self._trouble}:
            self._notices.tell("ups", f"device '{self.ctx.settings.device}': {trouble}")
        self._trouble = trouble

    def _publish(self, state: UpsState) -> None:
        """Publish the state, marked as emulated if the supply is behind a socket."""
        emulated = not self.device_row.address.startswith("i2c:")
        self.ctx.publish("state", replace(state, emulated=emulated))
