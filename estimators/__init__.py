"""Recursive estimators, regressors, metrics and transfer functions: numpy in, numpy out, no I/O."""
