"""Attributes that are worked out when they are first asked for, in objects made by the thousand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

T = TypeVar("T")


class lazy(Generic[T]):
    """``functools.cached_property`` without the lock it takes before Python 3.12, which costs as
    much as the work of a planning loop: one thread plans with an object.

    >>> class Square:
    ...     side = 3.0
    ...     @lazy
    ...     def area(self) -> float:
    ...         return self.side * self.side
    >>> square = Square()
    >>> square.area, vars(square)
    (9.0, {'area': 9.0})
    """

    def __init__(self, work: Callable[[Any], T]) -> None:
        self.work = work
        self.__doc__ = work.__doc__

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, instance: None, owner: type) -> lazy[T]: ...

    @overload
    def __get__(self, instance: object, owner: type) -> T: ...

    def __get__(self, instance: object | None, owner: type) -> lazy[T] | T:
        if instance is None:
            return self
        value = self.work(instance)
        instance.__dict__[self.name] = value
        return value
