"""Grey-box simulation of a joint, the catalogue of effects, and the workflow that names what is missing."""
