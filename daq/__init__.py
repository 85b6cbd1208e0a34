"""From bytes on the wire to SI units on a time axis: protocol, transports, driver, recordings."""
