"""What each command does: one function a command, grouped as in the protocol document."""
