"""The controller's fast loop: what the real program does in each PWM interrupt."""
