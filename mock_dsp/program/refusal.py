"""How a command that cannot be executed leaves its handler."""

from daq.protocol.codes import StatusCode


class RefusedError(Exception):
    """A command cannot be executed; `status` is what the reply says."""

    def __init__(self, status: StatusCode) -> None:
        super().__init__(status.name)
        self.status = status
