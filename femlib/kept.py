"""Contents of objects that cannot change: read-only mappings, and values that are made once."""

from collections.abc import Callable, Iterator, Mapping
from typing import Generic, TypeVar

Key = TypeVar("Key")
Value = TypeVar("Value")


class ReadOnly(Mapping[Key, Value]):
    """A copy of a mapping that cannot be written; unlike `types.MappingProxyType` it goes to other processes."""

    __slots__ = ("_held",)

    def __init__(self, held: Mapping[Key, Value]) -> None:
        self._held = dict(held)

    def __getitem__(self, key: Key) -> Value:
        return self._held[key]

    def __iter__(self) -> Iterator[Key]:
        return iter(self._held)

    def __len__(self) -> int:
        return len(self._held)

    def __repr__(self) -> str:
        return f"ReadOnly({self._held!r})"


class Kept(Generic[Key, Value]):
    """Values by key, each made when it is first asked for; no value depends on what was asked before."""

    __slots__ = ("_held",)

    def __init__(self) -> None:
        self._held: dict[Key, Value] = {}

    def get(self, key: Key, make: Callable[[], Value]) -> Value:
        """Return the value of a key, made now if it was not asked for before."""
        if key not in self._held:
            self._held[key] = make()
        return self._held[key]
