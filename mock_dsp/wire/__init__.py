"""The controller's serial line: pseudo-terminal, UART and FIFO model, pacing, injected line faults."""
