"""Loads a user's own estimator or controller by its import path."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from grex_link.errors import ConfigError


def load_plugin(path: str, name: str, known: Mapping[str, str]) -> Callable[..., Any]:
    """Find a class by a known name or by ``package.module:Class``.

    Parameters
    ----------
    path : str
        Where in the scenario the name stands, for the error message.
    name : str
        What stands there.
    known : mapping of str to str
        Short names and the import paths they stand for.

    Raises
    ------
    ConfigError
        If there is no such thing.
    """
    module_name, colon, attribute = known.get(name, name).partition(":")
    if not colon:
        raise ConfigError(path, f"{name!r} is not one of {', '.join(known)}, nor your_package.module:YourClass")
    try:
        module = import_module(module_name)
    except Exception as error:
        raise ConfigError(path, f"cannot import {module_name!r}: {type(error).__name__}: {error}") from error
    found: Any = getattr(module, attribute, None)
    if found is None:
        raise ConfigError(path, f"module {module_name!r} has no {attribute!r}")
    if not callable(found):
        raise ConfigError(path, f"{name!r} is not a class")
    found_class: Callable[..., Any] = found
    return found_class


def build_plugin(path: str, name: str, known: Mapping[str, str], argument: object, method: str) -> Any:
    """Find a class and build one of it.

    Parameters
    ----------
    path, name, known : str, str, mapping of str to str
        See `load_plugin`.
    argument : object
        What it is built from.
    method : str
        What it must be able to do.

    Raises
    ------
    ConfigError
        If there is no such class, it cannot be built from that, or it lacks the method.
    """
    build = load_plugin(path, name, known)
    try:
        built = build(argument)
    except ConfigError:
        raise
    except Exception as error:
        what = f"{type(argument).__name__}: {type(error).__name__}: {error}"
        raise ConfigError(path, f"{name!r} cannot be built from a {what}") from error
    if not hasattr(built, method):
        raise ConfigError(path, f"{name!r} has no method {method!r}")
    return built
