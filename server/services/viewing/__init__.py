"""Live data for viewers: what they may ask for, and the frames that they get."""
