"""Which effect is missing: judge, choose, prune, say what else it could be."""
