"""Compiled field-oriented control and the loop over PWM periods."""
