"""Options of one identification, shared by every estimator of the table. Checked here, trusted elsewhere."""

from dataclasses import dataclass, field

from estimators.structure import ModelStructure


@dataclass(frozen=True, slots=True, kw_only=True)
class IdentifyOptions:
    """What to identify and how.

    Attributes:
        order: number of past outputs and of past inputs (the paper's "number of delays", 2).
        delay: samples between input and first effect; the paper's models have 1.
        residual_terms: nc of extended RLS; 1 as in the paper's printed theta (eq. 21), N in its eq. 5.
        methods: names in `estimators.table.ESTIMATORS`.
        forgetting: lambda of RLS and extended RLS, in (0, 1]; the paper states no value.
        directional_forgetting: lambda of `rls_directional`, in (0, 1).
        reset_interval: samples between covariance resets of RLS and extended RLS; 0 for never.
        rw: diagonal of the parameters' drift covariance Rw of RLS-KF (paper, eq. 16).
        rv: variance Rv of the measurement noise of RLS-KF (paper, eq. 17).
        start_near_zero: start theta and P near zero, as the paper says, instead of with a large P.
        max_lag: lags of the residual correlations.
        select_order: whether to rank other orders and delays as well.
        structure: filled in; the model structure without residual terms.
    """

    order: int = 2
    delay: int = 1
    residual_terms: int = 1
    methods: tuple[str, ...] = ("rls", "erls", "rls_kf")
    forgetting: float = 1.0
    directional_forgetting: float = 0.98
    reset_interval: int = 0
    rw: float = 0.99
    rv: float = 0.99
    start_near_zero: bool = False
    max_lag: int = 25
    select_order: bool = True
    structure: ModelStructure = field(init=False)

    def __post_init__(self) -> None:
        """Check what no algorithm file checks.

        Raises:
            ValueError: If a value is out of range.
        """
        object.__setattr__(self, "methods", tuple(self.methods))
        object.__setattr__(self, "structure", ModelStructure(na=self.order, nb=self.order, delay=self.delay))
        if not self.methods:
            raise ValueError("methods is empty; name at least one estimator, for example rls")
        if len(set(self.methods)) != len(self.methods):
            raise ValueError(f"methods={','.join(self.methods)} names an estimator twice")
        if not 1 <= self.residual_terms <= 10:
            raise ValueError(
                f"residual_terms={self.residual_terms} must lie in [1, 10]; the paper's ERLS has 1"
            )
        if not 1 <= self.max_lag <= 500:
            raise ValueError(f"max_lag={self.max_lag} must lie in [1, 500]")
