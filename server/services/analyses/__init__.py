"""Analyses that run for minutes: each in a process of its own, one after the other, beside rigs that stream."""
