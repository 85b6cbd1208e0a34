"""Programs that use the Python client; each runs as it is: `python -m examples.run_campaign --help`."""
