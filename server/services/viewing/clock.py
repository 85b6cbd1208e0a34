"""When a controller's tick was, by the wall clock."""

import time

from daq.driver.rig import Rig as DriverRig

_WRAP = 1 << 32


def wall_clock_ns(driver: DriverRig, tick: int, now_ns: int) -> int:
    """Return when a tick was, by the fit of the controller's clock; 0 while there is none that holds.

    Args:
        driver: the open rig.
        tick: of the controller, unwrapped by whoever decoded the samples.
        now_ns: the wall clock at this moment, ns since 1970.
    """
    fit = driver.link_statistics().clock
    if fit is None or not fit.steady:
        return 0
    # Samples and fit unwrap the 32-bit counter each for itself.
    ahead = (tick - fit.tick0 + _WRAP / 2) % _WRAP - _WRAP / 2
    return now_ns - (time.monotonic_ns() - fit.t_ns_at(fit.tick0 + ahead))
