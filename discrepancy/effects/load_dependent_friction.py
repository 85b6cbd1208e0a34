"""Dry friction that grows with the torque the transmission carries."""

from discrepancy.effects.spec import Effect, EffectParameter, Kind, Port, Ranges, Start
from discrepancy.simulation import slots as s


def _starts(r: Ranges) -> list[Start]:
    return [{"coefficient": 0.05}, {"coefficient": 0.3}]


LOAD_DEPENDENT_FRICTION = Effect(
    id="load_dependent_friction",
    port=Port.TORQUE,
    driver="current_A",
    second_driver="speed_rad_s",
    equation="tau = -mu |tau_c| sign(w); tau_c = Kt i less the ripple, behind a belt or gap what that carries",
    parameters=(
        EffectParameter(
            name="coefficient",
            slot=s.LOAD_FRICTION,
            kind=Kind.RATIO,
            lower=0.0,
            upper=0.95,
            meaning="friction per transmitted torque",
        ),
    ),
    starts=_starts,
    signature="torque residual proportional to |current| with the sign of the speed: driving and braking differ",
    confused_with=("coulomb_friction", "viscous_friction_drift"),
    reference="M. Duclusaud et al., ICRA 2025 (arXiv 2410.08650), model M3",
)
