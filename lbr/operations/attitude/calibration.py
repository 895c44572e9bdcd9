"""A calibration of the compass from command to picture: collect or read, fit, store, draw. One at a time."""

from dataclasses import dataclass
from datetime import datetime
from importlib import import_module
from math import inf
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Literal

from msgspec.structs import replace

from lbr.capability.context import Call, Context
from lbr.errors import InputError
from lbr.leases.client import LeaseTarget
from lbr.leases.holder import Holder
from lbr.messages.attitude import AttitudeState, CalibrateCommand, CalibrationProgress
from lbr.messages.calibration import CalibrationValue, measured, values
from lbr.messages.codes import Code, Reason
from lbr.messages.drive import DriveCommand
from lbr.messages.imu import ImuSample
from lbr.messages.leases import CommandReply
from lbr.operations.attitude import picture
from lbr.operations.attitude.compass import MagCalibration
from lbr.operations.attitude.gravity import Gravity
from lbr.operations.attitude.picture import Drawing, Points
from lbr.operations.attitude.samples import FOLDER, MOST, Samples, load, save
from lbr.operations.attitude.settings import AttitudeSettings

if TYPE_CHECKING:
    from lbr.operations.attitude.fit import Fit
    from lbr.operations.attitude.fusion import Fusion

FITTING = "lbr.operations.attitude.fit"
"""Imported for the first calibration, as numpy takes 8 MiB; in a thread, as that takes up to a second."""
DRIVE = LeaseTarget("motion", "halt", "drive", "the drive does not answer")
CLOCKWISE_DEG, ANTICLOCKWISE_DEG = 90.0, 270.0
TURN, LOOK = "-", "-c"
PUBLISH_S = 0.2
STUCK_S = 3.0
STUCK_DEG = 5.0
HEADING_S = 2.0
"""The wait at the end of a calibration for a heading from it: several measurements of the slowest compass."""


class Collection:
    """Samples collected while the body spins, and the state of the spin."""

    def __init__(self, command: CalibrateCommand, call: Call, spin: Holder, epoch: str, now: float) -> None:
        self.wanted = command.samples
        self.keeps = command.source == TURN
        self.call: Call | None = call
        self.spin = spin
        self.epoch = epoch
        self.since_s = now
        self.samples = Samples()
        self._moved_s = now
        self._moved_from_deg = inf
        self._counted, self._counted_s = 0, now

    @property
    def turns(self) -> bool:
        """Return whether the drive accepted the command."""
        return self.spin.lease is not None and self.spin.lease.accepted is not None

    @property
    def complete(self) -> bool:
        """Return whether there are enough samples, from a full turn."""
        return len(self.samples) >= self.wanted and (self.samples.coverage >= 1.0 or len(self.samples) >= MOST)

    def is_stuck(self, turned_deg: float, now: float) -> bool:
        """Return whether the body has not turned for a while although it should."""
        if not self.turns or abs(turned_deg - self._moved_from_deg) > STUCK_DEG:
            self._moved_s, self._moved_from_deg = now, turned_deg
        return now - self._moved_s > STUCK_S

    def is_silent(self, now: float, every_s: float) -> bool:
        """Return whether the compass has delivered no sample for a while."""
        if not self.turns or len(self.samples) != self._counted:
            self._counted, self._counted_s = len(self.samples), now
        return now - self._counted_s > STUCK_S + every_s


@dataclass(frozen=True, slots=True)
class PendingReport:
    """A calibration in force, not reported yet: first a heading from it must be published, or `until` must pass."""

    samples: Samples
    wanted: int
    solution: "Fit"
    file: Path | None
    until: float


class Calibration:
    """Handles commands and samples; requests motion, stores the result, and publishes `calibration` and events."""

    def __init__(self, ctx: Context[AttitudeSettings], fusion: "Fusion | Gravity") -> None:
        self._ctx = ctx
        self._fusion = fusion
        self._collection: Collection | None = None
        self._loading = Thread(target=import_module, args=(FITTING,), daemon=True)
        self._file: tuple[Samples, Path, Call] | None = None
        self._pending: PendingReport | None = None
        self._published_s = -inf
        self._progress = CalibrationProgress(phase="done", collected=0, wanted=0, coverage=0.0)

    def command(self, call: Call) -> None:
        """Begin, unless one is in progress."""
        command: CalibrateCommand = call.message
        if self._collection is not None or self._pending is not None or self._file is not None:
            call.refuse("the compass is being calibrated already; 'stop' ends that", "busy")
            return
        if self._loading.ident is None:
            self._loading.start()
        begin = self._spin if command.source in {TURN, LOOK} else self._read
        begin(command, call)

    def stop(self, reason: str, code: Code) -> bool:
        """End the one in progress and halt; return whether there was one."""
        file, collection = self._file, self._collection
        if file is not None:
            self._file = None
            file[2].refuse(reason, code)
        elif collection is not None:
            collection.spin.release(reason)
            self._give_up(collection, Reason(code, reason))
        return file is not None or collection is not None

    def take(self, sample: ImuSample) -> None:
        """Store a sample, right after the fusion has processed it."""
        collection, turned_deg = self._collection, self._fusion.turned_deg
        if collection is not None and collection.turns and turned_deg is not None:
            collection.samples.take(sample, turned_deg, self._ctx.settings.sample_s)

    def published(self, state: AttitudeState) -> None:
        """Report a new calibration after the heading from it: a turn to a heading may follow at once."""
        pending = self._pending
        if pending is None or (state.heading_deg is None and self._ctx.clock() < pending.until):
            return
        self._pending = None
        doubt = f"; the heading is not known yet: {state.heading_reason}" if state.heading_deg is None else ""
        samples, solution = pending.samples, pending.solution
        self._done(samples, pending.wanted, _summary(solution) + doubt, solution)
        self._draw(samples, solution.calibration, pending.file, f"{solution.residual:.1%} of the field left over")

    def step(self) -> None:
        """Renew the motion, check for enough samples, and publish progress."""
        if self._collection is not None:
            self._collect(self._collection)
        if self._file is not None and not self._loading.is_alive():
            self._fit_file(*self._file)

    def close(self) -> None:
        """Stop the motion."""
        self.stop(f"{self._ctx.name} ends", "shutting_down")

    def _spin(self, command: CalibrateCommand, call: Call) -> None:
        state = self._fusion.state(self._ctx.clock())
        if not state.valid:
            call.refuse(f"how the body turns is not known: {state.reason}", "stale_sensor")
            return
        spin = Holder(self._ctx)
        spin.begin(DRIVE, self._turn(CLOCKWISE_DEG))
        self._collection = Collection(command, call, spin, state.epoch, self._ctx.clock())
        self._collect(self._collection)

    def _turn(self, angle_deg: float) -> DriveCommand:
        return DriveCommand(power=self._ctx.settings.spin_power, angle_deg=angle_deg)

    def _collect(self, collection: Collection) -> None:
        now, settings = self._ctx.clock(), self._ctx.settings
        legs = int((now - collection.since_s) / settings.reverse_s)
        ended = collection.spin.step()
        collection.spin.change(self._turn(CLOCKWISE_DEG if legs % 2 == 0 else ANTICLOCKWISE_DEG))
        if collection.turns and collection.call is not None:
            collection.call.reply(CommandReply(accepted=True, reason="turning on the spot to calibrate the compass"))
            collection.call = None
        state = self._fusion.state(now)
        collected, wanted = len(collection.samples), collection.wanted
        if ended is not None:
            self._give_up(collection, ended)
        elif not state.valid or state.epoch != collection.epoch:
            self.stop(
                f"how the body turns is not known any more: {state.reason or 'samples were missing'}", "stale_sensor"
            )
        elif collection.is_stuck(state.turned_deg or 0.0, now):
            self.stop("the robot does not turn, although the drive took the command", "stuck")
        elif collection.complete:
            self._finish(collection)
        elif collection.is_silent(now, settings.sample_s):
            self.stop("the compass measures nothing; 'lbr status' shows what the inertial unit lacks", "stale_sensor")
        elif now - collection.since_s > settings.calibration_limit_s:
            self.stop(
                f"{collected} of {wanted} samples within {settings.calibration_limit_s:g} s; ask for fewer", "timeout"
            )
        else:
            text = f"{collected} of {wanted} samples, {collection.samples.coverage:.0%} of a turn seen"
            self._collecting(collection, text, now)

    def _collecting(self, collection: Collection, text: str, now: float) -> None:
        if now - self._published_s >= PUBLISH_S:
            self._published_s = now
            self._publish(_progress("collecting", collection.samples, collection.wanted, text))

    def _give_up(self, collection: Collection, reason: Reason) -> None:
        self._collection = None
        if collection.call is not None:
            collection.call.refuse(reason)
        self._save(collection.samples)
        self._refused(collection.samples, collection.wanted, reason)

    def _finish(self, collection: Collection) -> None:
        collection.spin.release("the samples for the compass are collected")
        self._collection = None
        file = self._save(collection.samples)
        if collection.keeps:
            self._fit(collection.samples, collection.wanted, file)
        else:
            self._done(collection.samples, collection.wanted, "drawn as it is corrected now; nothing is kept")
            self._draw(collection.samples, self._fusion.calibration, file, "as it is corrected now")

    def _read(self, command: CalibrateCommand, call: Call) -> None:
        try:
            samples = load(self._ctx.home, command.source, self._fusion.up_sensor).thinned(command.samples)
        except InputError as err:
            call.refuse(str(err), err.code)
            return
        self._file = samples, Path(self._ctx.home) / FOLDER / command.source, call

    def _fit_file(self, samples: Samples, path: Path, call: Call) -> None:
        self._file = None
        if trouble := self._fit(samples, len(samples), path):
            call.refuse(trouble, "failed")
        else:
            call.reply(CommandReply(accepted=True, reason=_summary(self._pending.solution) if self._pending else ""))

    def _fit(self, samples: Samples, wanted: int, file: Path | None) -> str:
        """Fit and store the calibration; return the reason for a failure, or an empty string."""
        from lbr.operations.attitude.fit import FitError, fit  # noqa: PLC0415 - see FITTING

        self._publish(_progress("fitting", samples, wanted))
        try:
            solution = fit(samples.mags_ut, samples.ups, self._ctx.settings)
        except FitError as err:
            self._refused(samples, wanted, Reason("failed", str(err)))
            self._draw(samples, None, file, "refused")
            return str(err)
        self._ctx.learn(*measured(self._ctx.settings.device, solution.calibration.values()))
        self._fusion.calibrate(values(self._ctx.rows(CalibrationValue)))
        self._pending = PendingReport(samples, wanted, solution, file, self._ctx.clock() + HEADING_S)
        return ""

    def _done(self, samples: Samples, wanted: int, text: str, solution: "Fit | None" = None) -> None:
        done = _progress("done", samples, wanted, text)
        if solution is not None:
            done = replace(done, residual=solution.residual, coverage=solution.coverage)
        self._publish(done)
        data = {"samples": len(samples), "residual": done.residual}
        self._ctx.event("calibrated" if solution else "calibration_shown", f"the compass: {text}", data=data)

    def _refused(self, samples: Samples, wanted: int, reason: Reason) -> None:
        self._publish(_progress("refused", samples, wanted, reason.text))
        self._ctx.event(
            "calibration_refused", f"the compass is not calibrated: {reason}", level="warning", code=reason.code
        )

    def _save(self, samples: Samples) -> Path | None:
        """Write the samples to a file, if there are any; a full disk does not spoil the calibration."""
        if not len(samples):
            return None
        try:
            return save(self._ctx.home, samples, datetime.now().astimezone())
        except OSError as err:
            self._ctx.event("calibration_file", f"the samples could not be written down: {err}", level="warning")
            return None

    def _draw(self, samples: Samples, calibration: MagCalibration | None, file: Path | None, outcome: str) -> None:
        if file is None or not len(samples):
            return
        now = datetime.now().astimezone()
        drawing = Drawing(
            title=f"{self._ctx.robot}, {now:%Y-%m-%d %H:%M}: {len(samples)} samples, {outcome}",
            measured=_points(None, samples),
            corrected=[] if calibration is None else _points(calibration, samples),
        )
        path = file.with_suffix(".svg")
        try:
            picture.save(drawing, path)
        except OSError as err:
            self._ctx.event("calibration_picture", f"no picture was drawn: {err}", level="warning")
            return
        self._publish(replace(self._progress, picture=str(path), text=f"{self._progress.text}; drawn in {path}"))
        self._ctx.event("calibration_picture", f"the calibration of the compass is drawn in {path}")

    def _publish(self, progress: CalibrationProgress) -> None:
        self._progress = progress
        self._ctx.publish("calibration", progress)


def _progress(
    phase: Literal["collecting", "fitting", "done", "refused"], samples: Samples, wanted: int, text: str = ""
) -> CalibrationProgress:
    return CalibrationProgress(phase=phase, collected=len(samples), wanted=wanted, coverage=samples.coverage, text=text)


def _summary(solution: "Fit") -> str:
    x, y, z = solution.calibration.offset_ut
    shape = "level turn" if solution.flat else "all directions"
    return (
        f"calibrated by a {shape}: hard iron {x:.1f}, {y:.1f}, {z:.1f} uT; "
        f"{solution.residual:.1%} of the field left over, {solution.coverage:.0%} of a turn seen"
    )


def _points(calibration: MagCalibration | None, samples: Samples) -> Points:
    from lbr.operations.attitude.fit import level_part  # noqa: PLC0415 - see FITTING

    return [(float(x), float(y)) for x, y in level_part(calibration, samples.mags_ut, samples.ups)]
