"""Options of estimators: what cannot be meant is refused by name, before anything is recorded for it."""

import pytest

from estimators.table import ESTIMATORS
from server.services.errors import InvalidValueError
from server.services.estimator_choice import EstimatorChoice, check_choices, check_length, check_option_for
from server.services.identification import TUNABLE


def choose(*given: tuple[str, dict[str, float]]) -> dict[str, float]:
    return check_choices([EstimatorChoice(name=name, options=options) for name, options in given])


def test_the_options_of_all_estimators_are_those_of_the_identification() -> None:
    found = choose(("rls", {"forgetting": 0.99}), ("rls_kf", {"rw": 0.0, "rv": 2.0}), ("ls", {"max_lag": 10}))
    assert found == {"forgetting": 0.99, "rw": 0.0, "rv": 2.0, "max_lag": 10}


@pytest.mark.parametrize(
    ("given", "field", "words"),
    [
        ([("rls", {"forgetting": 0.0})], "estimators.0.options.forgetting", "(0, 1]"),
        ([("rls", {"reset_interval": -1})], "estimators.0.options.reset_interval", "0 (never)"),
        ([("rls", {"reset_interval": 1.5})], "estimators.0.options.reset_interval", "type int"),
        ([("rls_kf", {"rv": 0.0})], "estimators.0.options.rv", "positive variance"),
        ([("rls_directional", {"directional_forgetting": 1.0})], None, "(0, 1)"),
        ([("erls", {"residual_terms": 11})], "estimators.0.options.residual_terms", "[1, 10]"),
        (
            [("rls", {}), ("ls", {"forgetting": 0.9})],
            "estimators.1.options.forgetting",
            "nothing to the estimator",
        ),
        ([("rls", {"forgetting": 0.9}), ("erls", {})], "estimators.1.options.forgetting", "does not give it"),
        ([("rls", {"forgetting": 0.9}), ("erls", {"forgetting": 0.8})], None, "one forgetting"),
        ([("rls", {"max_lag": 10}), ("erls", {"max_lag": 20})], None, "one max_lag"),
        ([("ls", {}), ("ls", {})], "estimators.1.name", "twice"),
        ([("rsl", {})], "estimators.0.name", "choose from"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_field(
    given: list[tuple[str, dict[str, float]]], field: str | None, words: str
) -> None:
    with pytest.raises(InvalidValueError) as caught:
        choose(*given)
    assert field in (None, caught.value.field)
    assert words in str(caught.value)
    assert caught.value.remedy


def test_every_option_that_an_estimator_takes_may_be_set() -> None:
    assert {name for spec in ESTIMATORS.values() for name in spec.takes} == set(TUNABLE) - {"max_lag"}


def test_a_campaigns_option_must_mean_something_to_one_of_its_estimators() -> None:
    check_option_for(["ls", "rls"], "forgetting", 0.99)
    with pytest.raises(InvalidValueError, match="nothing"):
        check_option_for(["ls", "rls_kf"], "forgetting", 0.99)


@pytest.mark.parametrize(("method", "needed"), [("rls", 7), ("erls", 8)])
def test_a_record_must_give_more_rows_than_there_are_parameters(method: str, needed: int) -> None:
    check_length(needed, order=2, delay=1, methods=[method], options={})
    with pytest.raises(ValueError, match=f"at least {needed}"):
        check_length(needed - 1, order=2, delay=1, methods=[method], options={})
