"""Excitations: what they are, what they look like sample by sample, and whether the rig can bear them."""
