"""From counts on the wire to SI units."""
