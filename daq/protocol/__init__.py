"""The wire protocol of docs/protocol.md, for both roles: bytes in, messages out; no clock, thread or port."""
