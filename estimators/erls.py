"""Extended recursive least squares: RLS with past a-posteriori residuals as regressors (paper, eq. 6-9)."""

from dataclasses import replace

from estimators.recursive import RecursiveEstimator
from estimators.regressors import Regression
from estimators.rls import RlsOptions, choose_options, make_rls
from estimators.settings import IdentifyOptions


def make_erls(n_phi: int, n_residuals: int, options: RlsOptions) -> RecursiveEstimator:
    """Return extended RLS: RLS (eq. 6-8 are eq. 2-4) on a longer regressor.

        phi(k) = [-y(k-1).. -y(k-na), u(k-d)..., eps(k-1).. eps(k-nc)]     (eq. 5)
        eps(k) = y(k) - phi(k)' theta(k)                                   (eq. 9)

    eps is the a-posteriori residual: theta(k) already knows y(k). The residual terms stand for coloured
    noise, A y = B u + C e. The paper's eq. 5 has N residual terms, its printed result (eq. 21) one; nc = 1
    follows the result. Converges where 1/C - 1/2 is positive real (Ljung and Soederstrom 1983, section 4.4);
    not to be used where roots of C may be close to the unit circle.

    Args:
        n_phi: regressors made of y and u.
        n_residuals: nc, number of residual terms, >= 1.
        options: forgetting, reset and start; start values count the residual terms, too.
    """
    if n_residuals < 1:
        raise ValueError(f"n_residuals={n_residuals} must be at least 1; without residual terms use rls")
    inner = make_rls(n_phi + n_residuals, options)
    return replace(inner, n_phi=n_phi, n_memory=n_residuals)


def prepare_erls(regression: Regression, options: IdentifyOptions) -> RecursiveEstimator:
    """Return extended RLS for these data."""
    structure = replace(regression.structure, nc=options.residual_terms)
    chosen = choose_options(replace(regression, structure=structure), options)
    return make_erls(structure.n_phi, structure.nc, chosen)
