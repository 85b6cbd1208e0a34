"""The controller's program: what the DSP would run in its background task, in memory, without any I/O."""
