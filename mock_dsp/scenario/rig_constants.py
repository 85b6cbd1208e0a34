"""Physical constants of the emulated rig: motor, inverter, mechanics and sensors, with their ranges.

The defaults are the rig that `config/rigs/emulated.yaml` and `config/motors/joint1.yaml` document; a test
keeps the three equal. Angles and speeds are at the motor shaft unless a name says `joint`.
"""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, field_validator

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class Strict(BaseModel):
    """Frozen model that rejects unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class MotorConstants(Strict):
    """Induction motor, per phase, rotor referred to the stator (Table 1 of the paper).

    Table 1 prints 0.16 H as "rotor inductance" and "stator inductance". A mutual inductance of 0.884 H
    cannot exceed the self inductances, so 0.16 H are the leakages: Ls = Lr = 0.16 + 0.884 H.
    """

    stator_resistance_ohm: Positive = 35.58
    rotor_resistance_ohm: Positive = 87.44
    stator_leakage_h: Positive = 0.16
    rotor_leakage_h: Positive = 0.16
    mutual_inductance_h: Positive = 0.884
    pole_pairs: Annotated[int, Field(ge=1, le=8)] = 2
    inertia_kg_m2: Positive = 5.0e-4
    viscous_friction_nm_s_rad: NotNegative = 5.65e-4
    rated_current_a: Positive = 1.26

    @property
    def stator_inductance_h(self) -> float:
        """Self inductance of the stator."""
        return self.stator_leakage_h + self.mutual_inductance_h

    @property
    def rotor_inductance_h(self) -> float:
        """Self inductance of the rotor, referred."""
        return self.rotor_leakage_h + self.mutual_inductance_h


class MechanicsConstants(Strict):
    """Belt, pulleys and joint. At the motor shaft the joint's values count divided by `belt_ratio`^2."""

    belt_ratio: Annotated[float, Field(ge=1.0, le=100.0)] = 4.0
    joint_inertia_kg_m2: Positive = 7.92
    joint_viscous_friction_nm_s_rad: NotNegative = 13.6
    pulley_inertia_kg_m2: NotNegative = 4.5e-3
    pulley_viscous_friction_nm_s_rad: NotNegative = 0.049435
    travel_stop_rad: Positive = 31.4
    initial_position_rad: Annotated[float, Field(ge=-30.0, le=30.0)] = 0.0


class InverterConstants(Strict):
    """Three-phase bridge on a rectified 380 V mains, one SVPWM period a tick."""

    bus_voltage_v: Annotated[float, Field(ge=100.0, le=800.0)] = 540.0
    dead_time_s: Annotated[float, Field(ge=0.0, le=1e-5)] = 2.0e-6


class SensorConstants(Strict):
    """Noise of the Hall sensors (+-4 A on 12 bit) and of the ten-turn potentiometer (16 of 12 bit).

    Attributes:
        current_noise_a: Noise of one phase-current sample, A rms.
        potentiometer_noise_lsb: Noise of one 12-bit conversion, LSB rms. Sixteen are summed to 16 bit. At 0
            all sixteen agree and the sum keeps the 12-bit steps; from 0.5 on the noise dithers them away.
    """

    current_noise_a: Annotated[float, Field(ge=0.0, le=0.5)] = 3.0e-3
    potentiometer_noise_lsb: Annotated[float, Field(ge=0.0, le=50.0)] = 0.6

    @field_validator("potentiometer_noise_lsb")
    @classmethod
    def _check_dither(cls, value: float) -> float:
        if 0.0 < value < 0.5:
            raise ValueError(
                "must be 0 (no noise) or at least 0.5 LSB, where the sum of 16 is fully dithered"
            )
        return value


class RigConstants(Strict):
    """Everything physical of the rig without hidden effects."""

    motor: MotorConstants = MotorConstants()
    mechanics: MechanicsConstants = MechanicsConstants()
    inverter: InverterConstants = InverterConstants()
    sensors: SensorConstants = SensorConstants()
