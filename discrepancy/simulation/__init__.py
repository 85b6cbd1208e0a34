"""The compiled grey-box joint: every effect can be switched on top of any other."""
