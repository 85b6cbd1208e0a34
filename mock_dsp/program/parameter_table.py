"""The controller's parameters: unit, raw scale, range, default and lock, as one literal table."""

from enum import Enum, auto

from daq.protocol.codes import ParameterId
from daq.protocol.dictionary_entries import Parameter
from mock_dsp.control.parameters import FastLoopParameters


class Lock(Enum):
    """When a parameter cannot be written."""

    NEVER = auto()
    WHILE_ARMED = auto()
    ALWAYS = auto()


_FAST_LOOP = FastLoopParameters()
_TRAVEL_END_RAD = 31.4
LEASE_MS = range(50, 2001)
"""Leases that ARM grants, in ms."""


def _parameter(  # one call is one row of the table: six columns
    parameter: ParameterId,
    name: str,
    unit: str,
    limits: tuple[float, float, float, float],
    doc: str,
    lock: Lock = Lock.NEVER,
) -> Parameter:
    """Return one row; `limits` is (scale, minimum, maximum, default), SI except for the scale."""
    scale, minimum, maximum, default = limits
    return Parameter(
        id=parameter,
        name=name,
        unit=unit,
        scale=scale,
        minimum=minimum,
        maximum=maximum,
        default=default,
        writable=lock is not Lock.ALWAYS,
        writable_armed=lock is Lock.NEVER,
        doc=doc,
    )


PARAMETERS: tuple[Parameter, ...] = (
    _parameter(
        ParameterId.CURRENT_LIMIT_A,
        "current_limit_A",
        "A",
        (1e-3, 0.0, 2.0, _FAST_LOOP.current_limit_a),
        "Peak of the torque-producing current reference; the reference is clipped to it.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.SPEED_LIMIT_RAD_S,
        "speed_limit_rad_s",
        "rad/s",
        (1e-2, 0.1, 180.0, _FAST_LOOP.speed_limit_rad_s),
        "Motor speed beyond which the drive trips.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.TRAVEL_MIN_RAD,
        "travel_min_rad",
        "rad",
        (1e-3, -_TRAVEL_END_RAD, 0.0, _FAST_LOOP.travel_min_rad),
        "Motor position below which the drive trips; the end stop is at -31.4 rad.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.TRAVEL_MAX_RAD,
        "travel_max_rad",
        "rad",
        (1e-3, 0.0, _TRAVEL_END_RAD, _FAST_LOOP.travel_max_rad),
        "Motor position above which the drive trips; the end stop is at +31.4 rad.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.RATED_CURRENT_A,
        "rated_current_A",
        "A",
        (1e-3, 0.1, 1.26, _FAST_LOOP.rated_current_a),
        "Rms current that the motor carries for ever; the I2t model counts what is above.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.I2T_TIME_S,
        "i2t_time_s",
        "s",
        (1e-2, 0.1, 60.0, _FAST_LOOP.i2t_time_s),
        "Time constant of the I2t heat model.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.RAMP_TIME_S,
        "ramp_time_s",
        "s",
        (1e-3, 1e-3, 0.05, 0.05),
        "Time in which the reference goes to zero after an abort, a lost lease or a disarm.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.LEASE_DEFAULT_S,
        "lease_default_s",
        "s",
        (1e-3, 0.05, 2.0, 0.25),
        "Lease granted to an ARM that asks for none (lease_ms = 0).",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.CENTRING_GAIN_A_RAD,
        "centring_gain_A_rad",
        "A/rad",
        (1e-6, 0.0, 0.2, _FAST_LOOP.centring_gain_a_rad),
        "Gain of the centring loop on the low-passed position.",
    ),
    _parameter(
        ParameterId.CENTRING_BANDWIDTH_HZ,
        "centring_bandwidth_Hz",
        "Hz",
        (1e-6, 1e-4, 1.0, _FAST_LOOP.centring_bandwidth_hz),
        "Low-pass of the centring loop; keep it far below the excitation's band.",
    ),
    _parameter(
        ParameterId.FLUX_CURRENT_A,
        "flux_current_A",
        "A",
        (1e-4, 0.1, 1.0, _FAST_LOOP.flux_current_a),
        "Flux-producing current; 0.4455 A makes about 1.0 N m/A.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.CURRENT_LOOP_BANDWIDTH_HZ,
        "current_loop_bandwidth_Hz",
        "Hz",
        (0.1, 10.0, 300.0, _FAST_LOOP.current_loop_bandwidth_hz),
        "Closed-loop bandwidth of the current control.",
        Lock.WHILE_ARMED,
    ),
    _parameter(
        ParameterId.BUS_VOLTAGE_V,
        "bus_voltage_V",
        "V",
        (0.1, 0.0, 1000.0, 0.0),
        "DC link voltage, as measured.",
        Lock.ALWAYS,
    ),
    _parameter(
        ParameterId.TEMPERATURE_DEGC,
        "temperature_degC",
        "degC",
        (0.1, -40.0, 150.0, 25.0),
        "Temperature of the power stage, as measured.",
        Lock.ALWAYS,
    ),
    _parameter(
        ParameterId.OVER_CURRENT_A,
        "over_current_A",
        "A",
        (1e-3, 0.5, 3.9, _FAST_LOOP.over_current_a),
        "Phase current beyond which the drive trips at once.",
        Lock.WHILE_ARMED,
    ),
)
