"""What came of the battery, as a table: out of the report that pytest writes."""

from collections import Counter
from collections.abc import Sequence
from xml.etree import ElementTree as ET

from tests.lab.stage import Scene

OUTCOMES = ("passed", "**failed**", "skipped")


def of(xml: str) -> str:
    """Return a row for each test: what it was, whether it passed, what it measured, how long it took by the machine's clock."""
    rows = ["| test | | seen | s |", "|---|---|---|---|"]
    cases = list(ET.fromstring(xml).iter("testcase"))
    for case in cases:
        seen = "; ".join(f"{one.get('name')} {one.get('value')}" for one in case.iter("property"))
        name = f"{case.get('classname', '').rpartition('.')[2].removeprefix('test_')}: {_words(case.get('name', ''))}"
        rows.append(f"| {name} | {_outcome(case)} | {seen or _why(case)} | {float(case.get('time', 0)):.1f} |")
    passed = sum(_outcome(case) == "passed" for case in cases)
    return "\n".join([*rows, "", f"{passed} of {len(cases)} passed"])


def of_parts(xml: str) -> str:
    """Return a row for each part of the tests: how many came out how, and how long they took; and whatever did not pass, with why."""
    found: dict[str, Counter[str]] = {}
    took: Counter[str] = Counter()
    others: Counter[tuple[str, str, str]] = Counter()
    for case in ET.fromstring(xml).iter("testcase"):
        module = case.get("classname", "")
        part = ".".join(module.split(".")[:2])
        found.setdefault(part, Counter())[_outcome(case)] += 1
        took[part] += float(case.get("time", 0))
        if (outcome := _outcome(case)) != "passed":
            name = f"{module}: {_words(case.get('name', ''))}" if "failed" in outcome else part
            others[name, outcome, _why(case)] += 1
    rows = ["| part | passed | failed | skipped | s |", "|---|--:|--:|--:|--:|"]
    for part, each in found.items():
        rows.append(f"| {part} | {' | '.join(str(each[one]) for one in OUTCOMES)} | {took[part]:.0f} |")
    rows += ["", "| not passed | | why | times |", "|---|---|---|--:|"]
    rows += [f"| {' | '.join(one)} | {times} |" for one, times in others.items()]
    return "\n".join(rows)


def of_scenes(name: str, scenes: Sequence[Scene]) -> str:
    """Return a row for each scene: what it was, whether it passed, what was seen."""
    rows = [f"| {name} | | seen |", "|---|---|---|"]
    rows += [f"| {one.what} | {'passed' if one.passed else '**failed**'} | {one.seen} |" for one in scenes]
    return "\n".join([*rows, "", f"{sum(one.passed for one in scenes)} of {len(scenes)} passed"])


def _outcome(case: ET.Element) -> str:
    for tag, said in (("failure", "**failed**"), ("error", "**failed**"), ("skipped", "skipped")):
        if case.find(tag) is not None:
            return said
    return "passed"


def _why(case: ET.Element) -> str:
    found = next((one for tag in ("failure", "error", "skipped") if (one := case.find(tag)) is not None), None)
    text = "" if found is None else found.get("message", "")
    return text.partition("\n")[0].replace("|", "/")[:120]


def _words(name: str) -> str:
    return name.removeprefix("test_").replace("_", " ")
