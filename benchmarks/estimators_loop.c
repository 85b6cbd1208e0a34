/* The recursion of estimators/kernels/recursion.py in plain C: the yardstick of benchmarks/estimators.py.
 *
 * The same arithmetic on the same factors, with the same outputs (predictions, innovation variance, history of
 * theta), but without what the estimator adds for safety: no scratch copy, no check for finite numbers, no
 * counters. So it does less than the kernel it is compared with. */

void run_recursion(long n_samples, long n_phi, long n, const double *phi, const double *y, double lam, double rv,
                   const double *rw, int widen, double *theta, double *U, double *D, double *prior_out,
                   double *posterior_out, double *variance_out, double *history)
{
    double x[16], f[16], v[16], b[16], a[16], memory[16] = {0};
    for (long k = 0; k < n_samples; k++) {
        for (long i = 0; i < n; i++)
            x[i] = i < n_phi ? phi[k * n_phi + i] : memory[i - n_phi];
        if (widen) {
            D[0] += rw[0];
            for (long m = 1; m < n; m++) {
                double d = D[m] + rw[m], keep = D[m] / d, c;
                D[m] = d;
                for (long i = 0; i < m; i++) {
                    a[i] = -U[i * n + m];
                    U[i * n + m] *= keep;
                }
                c = rw[m] * keep;
                for (long j = m - 1; j > 0; j--) {
                    double ca = c * a[j], inverse;
                    d = D[j] + ca * a[j];
                    inverse = 1.0 / d;
                    c *= D[j] * inverse;
                    D[j] = d;
                    for (long i = 0; i < j; i++) {
                        a[i] -= a[j] * U[i * n + j];
                        U[i * n + j] += ca * inverse * a[i];
                    }
                }
                D[0] += c * a[0] * a[0];
            }
        }
        double prior = 0.0, excitation = 0.0, posterior = 0.0, alpha = 1.0, inverse = 1.0;
        for (long j = 0; j < n; j++) {
            double total = x[j];
            for (long i = 0; i < j; i++)
                total += U[i * n + j] * x[i];
            f[j] = total;
            v[j] = D[j] * total;
            excitation += total * v[j];
            prior += x[j] * theta[j];
        }
        double w = 1.0 / (lam * rv);
        for (long j = 0; j < n; j++) {
            double pull = w * f[j] * inverse, previous = alpha;
            alpha += w * f[j] * v[j];
            inverse = 1.0 / alpha;
            D[j] *= previous * inverse / lam;
            b[j] = v[j];
            for (long i = 0; i < j; i++) {
                double u = U[i * n + j];
                U[i * n + j] = u - pull * b[i];
                b[i] += u * v[j];
            }
        }
        double s = lam * rv + excitation, step = (y[k] - prior) / s;
        for (long j = 0; j < n; j++) {
            theta[j] += b[j] * step;
            posterior += x[j] * theta[j];
            history[k * n + j] = theta[j];
        }
        for (long i = n - n_phi - 1; i > 0; i--)
            memory[i] = memory[i - 1];
        memory[0] = y[k] - posterior;
        prior_out[k] = prior;
        posterior_out[k] = posterior;
        variance_out[k] = s;
    }
}
