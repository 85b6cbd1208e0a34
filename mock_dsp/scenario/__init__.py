"""What a run of the emulator is made of: rig, hidden effects, noise and faults."""
