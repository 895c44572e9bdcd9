"""`lbr doctor`."""

import click

from lbr.commands import checks
from lbr.commands.options import json_option, print_json

MARKS = {"good": ("ok  ", "green"), "hint": ("hint", "yellow"), "bad": ("BAD ", "red")}


@click.command("doctor")
@json_option
def command(as_json: bool) -> int:
    """Find faults of this machine, and show the cures. Needs no running robot. Exit code 1 if bad."""
    findings = []
    for finding in checks.examine():
        findings.append(finding)
        if as_json:
            continue
        mark, colour = MARKS[finding.level]
        click.echo(f"{click.style(mark, fg=colour)}  {finding.about}: {finding.text}")
        if finding.do:
            click.echo(f"      do: {finding.do}")
    if as_json:
        print_json(findings)
    return 1 if any(finding.level == "bad" for finding in findings) else 0
