"""Exceptions. All of them are a ``PhisindyError``."""

from ._native import DataError, NumericsError, PhisindyError, SpecError

__all__ = ["DataError", "NumericsError", "PhisindyError", "SpecError"]
