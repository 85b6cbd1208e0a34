"""The blind benchmark's own judgement: what counts as right, missed, unknown and wrong."""

import pytest

from benchmarks.blind.judge import Worth, classify, finds_place, wilson


def answer(verdict: str, *added: tuple[str, list[object]]) -> dict[str, object]:
    """Return the fields of a verdict that the scorer reads."""
    steps: list[dict[str, object]] = [{"added": None, "equivalents": []}]
    steps.extend({"added": name, "equivalents": equivalents} for name, equivalents in added)
    return {"verdict": verdict, "steps": steps}


COULOMB: tuple[str, list[object]] = ("coulomb_friction", [])


@pytest.mark.parametrize(
    ("hidden", "given", "worth"),
    [
        (["coulomb_friction"], answer("named", COULOMB), "right"),
        (["coulomb_friction"], answer("named", ("stribeck_friction", ["coulomb_friction"])), "right"),
        (["coulomb_friction"], answer("named", ("stribeck_friction", [])), "wrong"),
        (["coulomb_friction"], answer("unknown", ("stribeck_friction", [])), "wrong"),
        (["coulomb_friction"], answer("unknown", COULOMB), "unknown"),
        (["coulomb_friction"], answer("named", COULOMB, ("end_stop", [])), "wrong"),
        (["coulomb_friction"], answer("none"), "miss"),
        (["coulomb_friction", "end_stop"], answer("named", COULOMB), "miss"),
        (
            ["coulomb_friction", "load_torque_offset"],
            answer("named", ("asymmetric_coulomb_friction", [["coulomb_friction", "load_torque_offset"]])),
            "right",
        ),
        (
            ["coulomb_friction"],
            answer("named", ("asymmetric_coulomb_friction", [["coulomb_friction", "load_torque_offset"]])),
            "wrong",
        ),
        (
            ["gravity_unbalance", "load_torque_offset"],
            answer("named", ("gravity_unbalance", [["gravity_unbalance", "load_torque_offset"]])),
            "right",
        ),
        (
            ["gravity_unbalance"],
            answer("named", ("gravity_unbalance", [["gravity_unbalance", "load_torque_offset"]])),
            "right",
        ),
        (["asymmetric_coulomb_friction"], answer("named", COULOMB, ("load_torque_offset", [])), "right"),
        (["coulomb_friction", "end_stop"], answer("named", ("coulomb_friction", ["end_stop"])), "miss"),
        ([], answer("none"), "right"),
        ([], answer("named", COULOMB), "wrong"),
        ([], answer("unknown"), "unknown"),
        (["rotor_heating"], answer("unknown"), "right"),
        (["rotor_heating"], answer("none"), "miss"),
        (["rotor_heating"], answer("named", ("torque_constant_drift", [])), "wrong"),
    ],
)
def test_the_verdict_and_every_standing_name_count(
    hidden: list[str], given: dict[str, object], worth: str
) -> None:
    assert classify(hidden, given) is Worth(worth)


@pytest.mark.parametrize(
    ("verdict", "worth"), [("none", Worth.RIGHT), ("unknown", Worth.UNKNOWN), ("named", Worth.MISS)]
)
def test_a_gain_of_the_current_sensor_may_be_told_as_another_torque_constant(
    verdict: str, worth: Worth
) -> None:
    given = answer(verdict) | {"parameter_changes": [{"parameter": "torque_constant"}]}
    assert classify(["current_sensor_gain"], given) is worth


def test_a_name_beside_the_corrected_torque_constant_is_wrong() -> None:
    given = answer("named", COULOMB) | {"parameter_changes": [{"parameter": "torque_constant"}]}
    assert classify(["current_sensor_gain"], given) is Worth.WRONG


def test_a_named_gain_is_right_too() -> None:
    assert classify(["current_sensor_gain"], answer("named", ("current_sensor_gain", []))) is Worth.RIGHT


def test_unknown_at_the_right_place_is_told_from_unknown_elsewhere() -> None:
    found = [
        finds_place(["sticky_spot"], {"unknown": {"port": "torque", "driver": driver}})
        for driver in ("position_rad", "time_s")
    ]
    assert found == [True, False]


def test_interval_agrees_with_the_published_example() -> None:
    # R. G. Newcombe, Statistics in Medicine 17, 1998, table I: 81 of 263, method 3 (Wilson): 0.2553 to 0.3662.
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    # Rounding must not take an end out of its range: a table would print -0.0 %.
    assert all(wilson(0, total)[0] >= 0.0 and wilson(total, total)[1] <= 1.0 for total in range(1, 300))
