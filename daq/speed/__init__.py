"""Speed from the potentiometer: one method for the live path, the same one without delay for recordings."""
