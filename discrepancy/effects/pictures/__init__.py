"""The pictures of the catalogue: what each effect does, computed by the kernels that the search fits."""
