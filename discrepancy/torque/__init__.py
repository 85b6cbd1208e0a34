"""Judging by inverse dynamics, for recordings made in closed loop."""
