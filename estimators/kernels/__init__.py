"""Compiled numeric kernels of the estimators: plain functions on floats and arrays, nothing else."""
