"""The blind benchmark: cases hidden by the emulated rig's physics, solved from recordings alone."""
