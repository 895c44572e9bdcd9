"""An answer in lines for people: the sentence, its evidence, the cure, and the chain."""

from lbr.messages.why import Chain, Link

MARKS = {"ok": "ok", "past": "was", "doubt": "may", "held": "HOLDS", "unknown": "?"}
"""The words before a link: `may` holds some of the possible motions, `was` has ended the last one."""
AGO_S = ((86400.0, "d"), (3600.0, "h"), (60.0, "min"), (1.0, "s"))


def lines(chain: Chain, *, verbose: bool = False) -> list[str]:
    """Return an answer in lines; the chain of a healthy part only if `verbose`."""
    if chain.state == "ok" and not verbose:
        return [chain.text]
    answer = [chain.text if chain.state == "ok" else f"{chain.part}: {chain.text}"]
    facts = [f"code {chain.code}"] if chain.code else []
    facts += [f"for {ago(chain.since_s)}"] if chain.since_s is not None else []
    facts += [f"by {chain.evidence}"] if chain.evidence else []
    answer += [f"  {'; '.join(facts)}"] if facts else []
    answer += [f"  do: {chain.do}"] if chain.do else []
    return [*answer, *(_link(one, here=index == chain.first) for index, one in enumerate(chain.links))]


def ago(seconds: float) -> str:
    """Return a time in the greatest unit that fits."""
    size, unit = next(((size, unit) for size, unit in AGO_S if seconds >= size), (1.0, "s"))
    return f"{seconds / size:.0f} {unit}" if seconds >= 10.0 * size else f"{seconds / size:.1f} {unit}"


def _link(one: Link, *, here: bool) -> str:
    age = f" ({ago(one.age_s)} old)" if one.age_s is not None else ""
    return f"{'>' if here else ' '} {MARKS[one.state]:<5}  {one.name:<9}  {one.about}: {one.text}{age}"
