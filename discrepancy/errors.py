"""What the workflow refuses, and why: each message names the thing, the limit and the remedy."""


class GapInputError(ValueError):
    """The model or the recordings do not allow an answer: wrong columns, no excitation, broken time axis."""


class ModelFileError(GapInputError):
    """A model file has a key or value that is not allowed."""
