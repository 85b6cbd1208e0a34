"""The rigs that the service holds: one data task each, fan-out of samples, operator leases."""
