"""Hold the kernel's parameters still while a record is simulated.

The compiler must assume that a write to any array may change any other, and it counts references to an array for every
function that is given it: a loop that reads its parameters from an array spends most of its time on that. A tuple of
the same numbers can change for nobody. The results are the same to the last bit.
"""

from collections.abc import Callable

import numpy as np
from numba import types
from numba.extending import overload
from numba.np.unsafe.ndarray import to_fixed_tuple
from numpy.typing import NDArray

from discrepancy.simulation import slots as s

FloatArray = NDArray[np.float64]
_COUNT = s.N_SLOTS


def freeze(p: FloatArray) -> FloatArray:
    """Return the parameters, shape (N_SLOTS,), as compiled code reads them fastest: a tuple there, themselves here."""
    return p


@overload(freeze, strict=False)
def _compiled_freeze(p: types.Type) -> Callable[[FloatArray], FloatArray] | None:
    if not isinstance(p, types.Array):
        return None

    def frozen(p: FloatArray) -> FloatArray:
        return to_fixed_tuple(p, _COUNT)  # type: ignore[call-arg]  # numba passes the context

    return frozen
