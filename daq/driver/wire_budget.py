"""Whether a stream fits the line, decided before it starts; if it does not, which one would."""

from dataclasses import dataclass

from daq.driver.options import StreamPlan
from daq.errors import WireBudgetError
from daq.protocol.budget import default_batch, line_use, max_batch, propose_stream, wire_octets
from daq.protocol.dictionary import Dictionary


@dataclass(frozen=True, slots=True, kw_only=True)
class WireBudget:
    """A stream that fits.

    Attributes:
        layout: Name of the layout.
        layout_id: Its number on the wire.
        divisor: Controller ticks per sample.
        batch: Samples per frame.
        baud: Rate of the line, 1/s.
        line_use: Share of the line that the stream takes.
        octets_per_s: Octets on the wire per second.
    """

    layout: str
    layout_id: int
    divisor: int
    batch: int
    baud: int
    line_use: float
    octets_per_s: float


def plan_wire(
    plan: StreamPlan, dictionary: Dictionary, *, baud: int, tick_hz: int, limit: float
) -> WireBudget:
    """Return the budget of `plan`.

    Raises:
        KeyError: No such layout; the message lists those that exist.
        ValueError: Divisor or batch out of range.
        WireBudgetError: The stream would take more than `limit` of the line; the message proposes one that fits.
    """
    layout = dictionary.layout(plan.layout)
    channels = len(layout.channels)
    if not 1 <= plan.divisor <= 65535:
        raise ValueError(f"divisor={plan.divisor} must lie in [1, 65535]")
    batch = default_batch(channels) if plan.batch is None else plan.batch
    octets_per_s = wire_octets(channels, batch) * tick_hz / (plan.divisor * batch)
    use = line_use(baud, channels, batch, plan.divisor, tick_hz)
    if use > limit:
        proposal = _propose(plan, dictionary, baud, tick_hz, limit)
        raise WireBudgetError(
            f"layout '{layout.name}' with divisor {plan.divisor} and {batch} samples a frame takes {use:.0%} of "
            f"{baud} baud, the limit is {limit:.0%}; {proposal or 'raise the baud rate'}",
            line_use=use,
            limit=limit,
            proposal=proposal,
        )
    return WireBudget(
        layout=layout.name,
        layout_id=layout.id,
        divisor=plan.divisor,
        batch=batch,
        baud=baud,
        line_use=use,
        octets_per_s=octets_per_s,
    )


def _propose(plan: StreamPlan, dictionary: Dictionary, baud: int, tick_hz: int, limit: float) -> str:
    """Return what fits, in words: the same rate if some layout allows it, else the same layout more slowly."""
    words = []
    for layout in sorted(dictionary.layouts, key=lambda layout: layout.name != plan.layout):
        channels = len(layout.channels)
        use = line_use(baud, channels, max_batch(channels), plan.divisor, tick_hz)
        if use <= limit:
            words.append(f"layout '{layout.name}' with {max_batch(channels)} samples a frame ({use:.0%})")
            break
    slower = propose_stream(baud, len(dictionary.layout(plan.layout).channels), tick_hz, limit)
    if slower is not None and slower.divisor > plan.divisor:
        words.append(f"divisor {slower.divisor} with {slower.batch} samples a frame ({slower.line_use:.0%})")
    return "use " + ", or ".join([*words, "a higher baud rate"]) if words else ""
