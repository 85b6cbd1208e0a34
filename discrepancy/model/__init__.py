"""The joint model file: nameplate parameters, effects, how it is judged."""
