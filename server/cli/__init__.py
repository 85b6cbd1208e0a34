"""The command line: parses arguments, calls services, renders what they report. No logic of its own."""
