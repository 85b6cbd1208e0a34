"""RLS-KF exactly as Algorithm 1 of the paper prints it: the regressor is one sample old."""

from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression
from estimators.rls_kf import RlsKfOptions, choose_options, make_weights
from estimators.settings import IdentifyOptions


def make_rls_kf_literal(n_phi: int, options: RlsKfOptions) -> RecursiveEstimator:
    """Return Algorithm 1, read literally.

        yhat(t) = x' theta;  P = P + Rw;  K = P x / (Rv + x' P x);  theta = theta + K (y(t) - yhat(t))
        P = (I - K x') P;  x = phi(t)                    (last line of the loop)

    so x holds phi(t-1): the model is y(t) = f(y(t-2), y(t-3), u(t-2), u(t-3)) and its transfer function has
    one delay more than the paper prints. The algorithm's regressor also lacks the minus signs of eq. 5; that
    only flips the sign of a1 and a2, so this estimator takes the usual regressor and returns the usual signs.
    For comparison with the paper only; use `rls_kf`, or better `rls_kf_ml`.

    Args:
        n_phi: number of regressors.
        options: variances and start; Algorithm 1 starts near zero (`estimators.start.NEAR_ZERO`).
    """
    return RecursiveEstimator(
        weights=make_weights(n_phi, options, lagged=True),
        theta0=options.start.parameters(n_phi),
        n_phi=n_phi,
        n_memory=n_phi,
    )


def prepare_rls_kf_literal(regression: Regression, options: IdentifyOptions) -> RecursiveEstimator:
    """Return the literal RLS-KF for these data."""
    return make_rls_kf_literal(regression.structure.n_phi, choose_options(regression, options))
