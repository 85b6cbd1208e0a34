"""From recordings to arrays the fits can use: cleaning, binning, repeats, noise."""
