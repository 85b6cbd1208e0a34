"""Estimators that learn while a record is being made."""
