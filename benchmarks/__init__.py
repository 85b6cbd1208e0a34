"""Programs that measure what benchmarks/README.md claims."""
