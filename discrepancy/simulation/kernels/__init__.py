"""The compiled joint, split by responsibility: laws, the plain joint, the whole joint, inverse dynamics."""
