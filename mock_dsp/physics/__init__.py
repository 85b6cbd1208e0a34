"""The emulated machine: induction motor, inverter, belt, joint and sensors, from their own equations."""
