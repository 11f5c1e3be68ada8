"""JSON has no NaN: what was no number comes back as null, and is put in again where a number must stand."""

import math
import types
from collections.abc import Iterator
from typing import Annotated, Any, Union, get_args, get_origin

import msgspec


def with_nan(data: Any, kind: Any) -> Any:
    """Replace null by NaN wherever a type wants a float and nothing else.

    Parameters
    ----------
    data
        Decoded JSON.
    kind
        The type it was encoded from; Structs, lists and unions of tagged Structs are followed.
    """
    if get_origin(kind) is Annotated:
        kind = get_args(kind)[0]
    if kind is float:
        return math.nan if data is None else data
    if isinstance(data, list) and get_origin(kind) is list:
        return [with_nan(each, get_args(kind)[0]) for each in data]
    if isinstance(data, dict):
        for struct in _structs(kind):
            if struct.__struct_config__.tag in {None, data.get("type")}:
                types_of = {field.encode_name: field.type for field in msgspec.structs.fields(struct)}
                return {name: with_nan(each, types_of.get(name, Any)) for name, each in data.items()}
    return data


def _structs(kind: Any) -> Iterator[Any]:
    for each in get_args(kind) if get_origin(kind) in {Union, types.UnionType} else (kind,):
        if isinstance(each, type) and issubclass(each, msgspec.Struct):
            yield each
