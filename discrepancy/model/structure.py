"""What a model's equations leave open whatever the records are: one number under two names."""

from dataclasses import replace

from discrepancy.model.schema import BASE_SLOTS, JointModel
from discrepancy.simulation import slots as s


def hold_scale(model: JointModel) -> tuple[JointModel, list[str]]:
    """Hold the torque constant where inertia and friction are free too: motion shows only their ratios."""
    named = {BASE_SLOTS[name]: name for name in model.parameters}
    constant, inertia = named.get(s.TORQUE_CONSTANT), named[s.INERTIA]
    friction = named.get(s.VISCOUS)
    free = [name for name in (constant, inertia, friction) if name and not model.parameters[name].fixed]
    if constant is None or len(free) < 3:
        return model, []
    held = {**model.parameters, constant: replace(model.parameters[constant], fixed=True)}
    note = (
        f"{', '.join(free)} cannot all be identified from current and motion, which show only their ratios: "
        f"{constant} is held at its nameplate value. "
        "A known load or a torque measurement at standstill would settle the scale"
    )
    return replace(model, parameters=held), [note]


def parameters_in_disguise(model: JointModel) -> frozenset[str]:
    """Return effects that are nothing but a free parameter: a sensor gain is the torque constant's scale."""
    free = any(BASE_SLOTS[n] == s.TORQUE_CONSTANT and not q.fixed for n, q in model.parameters.items())
    return frozenset({"current_sensor_gain"} if free and model.input == "current_A" else ())
