"""Changes of the tables, in order; they travel inside the package, so that an installed wheel can migrate."""
