"""Tickets and wrong tokens, with a clock of their own."""

from server.services.attempts import FailedAttempts
from server.services.tickets import TICKET_S, TicketOffice
from server.services.tokens import Principal, Scope

ALLOWED = 20
WHO = Principal(token_id="t", name="n", scopes=frozenset({Scope.READ}))


class Clock:
    """Time that stands until it is set."""

    now_s = 0.0

    def __call__(self) -> float:
        """Return it."""
        return self.now_s


def test_a_ticket_is_good_once() -> None:
    office = TicketOffice(Clock())
    ticket = office.issue(WHO)
    assert office.redeem(ticket) == WHO
    assert office.redeem(ticket) is None


def test_a_ticket_is_good_for_half_a_minute() -> None:
    clock = Clock()
    office = TicketOffice(clock)
    ticket = office.issue(WHO)
    clock.now_s = TICKET_S
    assert office.redeem(ticket) is None


def test_a_wrong_ticket_uses_up_nobody_elses() -> None:
    office = TicketOffice(Clock())
    ticket = office.issue(WHO)
    assert office.redeem("wrong") is None
    assert office.redeem(ticket) == WHO


def test_few_wrong_tokens_are_forgiven_and_many_must_wait_each_address_for_itself() -> None:
    attempts = FailedAttempts(ALLOWED, Clock())
    assert [attempts.note("a") for _ in range(ALLOWED)] == [0.0] * ALLOWED
    assert attempts.note("a") > 0.0
    assert attempts.note("b") == 0.0


def test_waiting_long_enough_clears_an_address() -> None:
    clock = Clock()
    attempts = FailedAttempts(ALLOWED, clock)
    for _ in range(10 * ALLOWED):
        attempts.note("a")
    clock.now_s = 150.0
    assert attempts.note("a") == 0.0
