"""Settings of the fast loop that the controller program may change between blocks of ticks."""

from dataclasses import dataclass

TICK_S = 1.0 / 2500.0
CURRENT_SCALE_A = 2.0**-13
SPEED_SCALE_RAD_S = 2.0**-7
POSITION_COUNTS = 65536


@dataclass(frozen=True, slots=True, kw_only=True)
class FastLoopParameters:
    """What the program sets; defaults are the rig's documented ones.

    Attributes:
        pwm_on: Bridge switching. Off, the motor coasts and nothing trips. After switching on the rotor flux
            takes about 50 ms to build up; the torque is less until then.
        centring_on: Add the centring loop's output to the reference; its low-pass starts where the joint is.
        centring_gain_a_rad: Its gain, A/rad, on the low-passed position.
        centring_bandwidth_hz: Its low-pass, Hz.
        current_limit_a: The torque-producing reference is clipped to +-this, A.
        over_current_a: A measured phase current beyond this trips, A peak.
        rated_current_a: Current that the motor carries for ever, A rms.
        i2t_time_s: Time constant of the I2t heat model, s.
        speed_limit_rad_s: Trip level of the controller's own speed.
        travel_min_rad: Trip level of the measured position, rad.
        travel_max_rad: Trip level of the measured position, rad.
        flux_current_a: Reference of the flux-producing current, A.
        current_loop_bandwidth_hz: Closed-loop bandwidth of the current control, Hz.
        sensor_stuck_ticks: The potentiometer has failed when its reading repeats this often; 0 = no check.
    """

    pwm_on: bool = False
    centring_on: bool = False
    centring_gain_a_rad: float = 0.01
    centring_bandwidth_hz: float = 0.005
    current_limit_a: float = 2.0
    over_current_a: float = 3.0
    rated_current_a: float = 1.26
    i2t_time_s: float = 10.0
    speed_limit_rad_s: float = 180.0
    travel_min_rad: float = -29.8
    travel_max_rad: float = 29.8
    flux_current_a: float = 0.4455
    current_loop_bandwidth_hz: float = 150.0
    sensor_stuck_ticks: int = 250
