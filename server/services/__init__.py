"""What Jointscope does, as plain functions: no printing, no HTTP, no argument parsing."""
