"""What is wrong with a file, in one line that names the field and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import BaseModel, ValidationError

from ..exceptions import shown


class Form(NamedTuple):
    """What a file may hold.

    Attributes:
        whole: The model of the whole file.
        tables: The models of its tables by name.
        free: Tables whose keys are the parameters of something registered, or names that the file makes up.
        items: Models of what else may be a part of a field's path.
    """

    whole: type[BaseModel]
    tables: Mapping[str, type[BaseModel]]
    free: tuple[str, ...]
    items: tuple[type[BaseModel], ...] = ()

    def explain(self, error: ValidationError) -> str:
        """Put all errors into one line; those of one field, which has alternatives, are joined."""
        by_field: dict[str, list[str]] = {}
        for each in error.errors():
            field, message = self._explain_one(each)
            by_field.setdefault(field, []).append(message)
        return "; ".join(field + " or".join(dict.fromkeys(messages)) for field, messages in by_field.items())

    def fields(self, location: Sequence[Any] = ()) -> list[str]:
        """Return the fields that the table at `location` may have."""
        if not location:
            return [name for name in self.whole.model_fields if name != "folder"]
        return list(self.tables[str(location[0])].model_fields)

    def _explain_one(self, error: Mapping[str, Any]) -> tuple[str, str]:
        """Return the field that an error is about, and what is wrong with it, to be written behind the field."""
        unknown = error["type"] == "extra_forbidden"
        *tables, last = error["loc"] or ("",)
        location = [*self._location(tables), last] if unknown else self._location(error["loc"])
        field = ".".join(str(part) for part in location) or "the file"
        if unknown:
            allowed = self.fields(location[:-1])
            nearest = difflib.get_close_matches(str(location[-1]).lower(), allowed, n=1)
            hint = f", did you mean {nearest[0]!r}?" if nearest else ";"
            return f"unknown field {field!r}", f"{hint} allowed: {', '.join(allowed)}"
        if error["type"] in ("model_type", "model_attributes_type"):
            return field, f": must be a table, got {shown(error['input'])}"
        message = error["msg"].removeprefix("Value error, ")
        given = "" if error["type"] in ("missing", "value_error") else f", got {shown(error['input'])}"
        return field, f": {message}{given}"

    def _location(self, location: Sequence[Any]) -> list[Any]:
        """Leave out what pydantic adds to the path of a field to tell the alternatives of its type apart."""
        models = (self.whole, *self.tables.values(), *self.items)
        known = {name for model in models for name in model.model_fields}
        first, *rest = location or ("",)
        # Names that a file makes up stand below `locked` and as parameters of what is registered.
        free = first in self.free or rest[:1] == ["locked"]
        kept = [part for part in rest if isinstance(part, int) or part in known or free]
        return [part for part in (first, *kept) if part != ""] if location else []
