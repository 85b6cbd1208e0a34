"""The emulated controller and the physics behind it; started as a process of its own."""
