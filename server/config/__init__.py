"""YAML files read once into frozen models that reject unknown keys and name file, line and field."""
