"""What else would tell effects apart where no current that the rig may be sent does."""

_UNFILTERED = "record the position too, or a second speed sensor without filter"
OTHER: dict[frozenset[str], str] = {
    frozenset({"load_torque_offset", "current_sensor_offset"}): (
        "read the current sensor with the drive switched off: what it then shows is its own offset; the rest of the "
        "torque is the load's"
    ),
    frozenset({"asymmetric_coulomb_friction", "coulomb_friction", "load_torque_offset"}): (
        "both are the same law while the joint moves: measure the torque that holds the joint at rest with the drive "
        "switched off (a spring balance); friction needs none, a load does"
    ),
    frozenset({"asymmetric_coulomb_friction", "coulomb_friction", "current_sensor_offset"}): (
        "read the current sensor with the drive switched off: what it then shows is its own offset; if none, the "
        "friction is asymmetric"
    ),
    frozenset({"transport_delay", "current_loop_lag"}): (
        "record the measured current beside its reference with the rotor locked: a delay shifts a step, a lag rounds it"
    ),
    frozenset({"transport_delay", "speed_filter_lag"}): _UNFILTERED,
    frozenset({"current_loop_lag", "speed_filter_lag"}): _UNFILTERED,
    frozenset({"torque_saturation", "current_saturation"}): (
        "record the measured current beside its reference: only a limited current falls behind it"
    ),
    frozenset({"backlash", "belt_compliance"}): "put a second angle sensor on the load's side of the gear or belt",
    frozenset({"viscous_friction_drift", "torque_constant_drift"}): (
        "lock the rotor and measure the torque at one current, cold and warm: only a drifting torque constant changes "
        "it"
    ),
    frozenset({"current_sensor_gain", "load_dependent_friction"}): (
        "lock the rotor and measure its torque at a few currents, or compare the current with a second instrument"
    ),
    frozenset({"gravity_unbalance", "torque_ripple"}): (
        "turn the joint's base by a right angle, or take the load off: a weight's torque moves or goes, the motor's "
        "stays"
    ),
}  # fmt: skip
FALLBACK = "a torque sensor at the joint, a known load, or a second motion sensor on the other side of the gear would"


def other_measurement(first: str, second: str | tuple[str, ...]) -> str:
    """Return the measurement that tells an effect from another, or from several together."""
    rivals = {second} if isinstance(second, str) else set(second)
    return OTHER.get(frozenset({first} | rivals), FALLBACK)
