"""Bounded nonlinear least squares on the compiled simulation."""
