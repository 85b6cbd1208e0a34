"""Which past samples a model uses, and the order of its parameters."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelStructure:
    """Orders and delay of A(q) y = B(q) u(k - delay) + C(q) e.

    Attributes:
        na: number of past outputs (a_1..a_na), >= 1.
        nb: number of past inputs (b_0..b_(nb-1)), >= 1.
        delay: samples between the input and its first effect, >= 1. The paper's models have 1.
        nc: number of past residuals (c_1..c_nc), extended RLS only.
    """

    na: int
    nb: int
    delay: int = 1
    nc: int = 0

    def __post_init__(self) -> None:
        """Check the orders.

        Raises:
            ValueError: If an order or the delay is out of range.
        """
        for name, least in (("na", 1), ("nb", 1), ("delay", 1), ("nc", 0)):
            value = getattr(self, name)
            if not least <= value <= 50:
                raise ValueError(f"{name}={value} must lie in [{least}, 50]")

    @property
    def n_phi(self) -> int:
        """Regressors made of y and u."""
        return self.na + self.nb

    @property
    def n_parameters(self) -> int:
        """Parameters in all, p of the adjusted R2."""
        return self.n_phi + self.nc

    @property
    def reach(self) -> int:
        """Samples of the past that one regressor needs."""
        return max(self.na, self.delay + self.nb - 1)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names in the order of theta: a1.., b0.., c1.. (paper, eq. 5, 19 and 21)."""
        a = tuple(f"a{i + 1}" for i in range(self.na))
        b = tuple(f"b{j}" for j in range(self.nb))
        return a + b + tuple(f"c{i + 1}" for i in range(self.nc))

    @property
    def regressor_names(self) -> tuple[str, ...]:
        """What each parameter multiplies, in the order of theta."""
        y = tuple(f"-y(k-{i + 1})" for i in range(self.na))
        u = tuple(f"u(k-{self.delay + j})" for j in range(self.nb))
        return y + u + tuple(f"e(k-{i + 1})" for i in range(self.nc))
