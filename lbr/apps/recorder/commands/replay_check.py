"""`lbr replay --check`: runs a recording through the real drivers and operations, and compares the results."""

import math
import sys
import time

import click

from lbr.apps.recorder.recording.selection import Chosen
from lbr.apps.recorder.rerun.check import Outcome, Recorded
from lbr.commands.options import print_json

SHOWN = 5


def check(chosen: Chosen, tries: int, *, as_json: bool) -> int:
    """Rerun a recording, up to `tries` times until the results match; print the differences, return the exit code."""
    from lbr.apps.recorder.rerun import check as checks  # noqa: PLC0415 - kept out of its `--help`

    recorded = checks.read(chosen.files, chosen.start_ns, chosen.end_ns)
    if not as_json:
        devices = ", ".join(
            f"{name} ({len(line.exchanges)})" for name, line in sorted(recorded.exchanged.lines.items())
        )
        seconds = (recorded.end_ns - recorded.start_ns) / 1e9
        commands = len(recorded.exchanged.commands)
        click.echo(f"{chosen.name}: {seconds:.1f} s of '{recorded.robot}', exchanges of {devices}; {commands} commands")
    for number in range(1, tries + 1):
        outcome = checks.run(recorded, _progress if not as_json else lambda _text: None)
        _clear()
        if not as_json:
            _print(outcome, recorded)
        if outcome.same or number == tries:
            break
        if not as_json:
            why = "as this machine was busy" if outcome.late else "in case it was chance"
            click.echo(f"once more, {why}: run {number + 1} of {tries}")
    if as_json:
        print_json(_plain(outcome, recorded, number))
    return 0 if outcome.same else 1


def _progress(text: str) -> None:
    if sys.stderr.isatty():
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def _clear() -> None:
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def _print(outcome: Outcome, recorded: Recorded) -> None:
    for name, why in sorted(outcome.left_out.items()):
        click.echo(f"  without {name}: {why}", err=True)
    for topic, count in outcome.setpoints.items():
        diffs = outcome.differences[topic]
        some = f" but {len({diff.at_ns for diff in diffs})}" if diffs and not outcome.differs(topic) else ""
        verdict = (
            f"all{some} as recorded" if not outcome.differs(topic) else _verdict(len({diff.at_ns for diff in diffs}))
        )
        click.echo(f"{topic:<28} {count} samples, {verdict}")
        for diff in diffs[:SHOWN] if outcome.differs(topic) else ():
            click.echo(
                f"    {_at(diff.at_ns, recorded)} {diff.field}: {_value(diff.recorded)} then, {_value(diff.now)} now"
            )
    click.echo(f"{'commands':<28} {outcome.commands}, {_verdict(len(outcome.answered_otherwise))}")
    for call in outcome.answered_otherwise[:SHOWN]:
        asked = call.command
        then, now = _answer(asked.reply), _answer(call.reply) if call.reply is not None else "no answer"
        click.echo(
            f"    {_at(asked.at_ns, recorded)} {asked.to}/{asked.name} by {asked.source}: {then} then, {now} now"
        )
    if outcome.begun_before:
        click.echo(f"    {outcome.begun_before} went by a lease from before the recording, and were left out")
    click.echo(f"{'reasons':<28} {outcome.reasons}, {_verdict(len(outcome.missing) + len(outcome.added))}")
    for text, events in (("then alone", outcome.missing), ("now alone", outcome.added)):
        for happened in events[:SHOWN]:
            what = f"{happened.subject} {happened.kind} [{happened.code}]"
            click.echo(f"    {_at(happened.at_ns, recorded)} {what}: {text}")
    for device, sent in sorted(outcome.asked.items()):
        if sent.unlike:
            example = repr(sent.unlike[0][:24])[1:]
            click.echo(f"  {device} was sent {sent.times} times, also what it was not sent then: {example}", err=True)
    click.echo(_judgement(outcome))


def _plain(outcome: Outcome, recorded: Recorded, tries: int) -> dict[str, object]:
    return {
        "robot": recorded.robot,
        "recorded_at": time.strftime("%Y-%m-%dT%H:%M:%S", time.localtime(recorded.start_ns / 1e9)),
        "seconds": round(outcome.seconds, 3),
        "same": outcome.same,
        "tries": tries,
        "runs": outcome.runs,
        "left_out": outcome.left_out,
        "setpoints": {
            topic: {
                "samples": count,
                "differences": [
                    {
                        "at_s": (diff.at_ns - recorded.start_ns) / 1e9,
                        "field": diff.field,
                        "then": None if math.isnan(diff.recorded) else diff.recorded,
                        "now": None if math.isnan(diff.now) else diff.now,
                    }
                    for diff in outcome.differences[topic]
                ],
            }
            for topic, count in outcome.setpoints.items()
        },
        "commands": {
            "said": outcome.commands,
            "begun_before": outcome.begun_before,
            "otherwise": [
                {
                    "at_s": (call.command.at_ns - recorded.start_ns) / 1e9,
                    "command": f"{call.command.to}/{call.command.name}",
                    "then": call.command.reply,
                    "now": call.reply,
                }
                for call in outcome.answered_otherwise
            ],
        },
        "reasons": {
            "told": outcome.reasons,
            "then_alone": [list(event.identity) for event in outcome.missing],
            "now_alone": [list(event.identity) for event in outcome.added],
        },
        "late_s": outcome.late_s,
    }


def _judgement(outcome: Outcome) -> str:
    if outcome.late:
        late = f"messages of then came up to {outcome.late_s:.1f} s late"
        return f"nothing is shown by this run: {late}, as this machine is too busy; run it when it has time"
    return "as recorded" if outcome.same else "otherwise than recorded"


def _verdict(differences: int) -> str:
    return "all as recorded" if not differences else f"{differences} otherwise"


def _at(at_ns: int, recorded: Recorded) -> str:
    return f"at {(at_ns - recorded.start_ns) / 1e9:.2f} s"


def _value(value: float) -> str:
    return "nothing" if math.isnan(value) else f"{value:g}"


def _answer(reply: object) -> str:
    found = reply if isinstance(reply, dict) else {}
    code = f" ({found['code']})" if found.get("code") else ""
    return ("accepted" if found.get("accepted", True) else "refused") + code
