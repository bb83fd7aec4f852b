"""The methods of `hello` as attributes: q.status(), q.camera.orbit(yaw=15)."""

from typing import Any, Callable, Dict, List

from . import schema
from .errors import MethodNotFound

Call = Callable[[str, Dict[str, Any]], Any]


class Method:
    """One method. Its signature and its documentation are those of the quiltd that is connected."""

    def __init__(self, call: Call, name: str, about: Dict[str, Any]) -> None:
        self._call, self._name, self._schema = call, name, about.get("params", {})
        self.__name__ = name.rsplit(".", 1)[-1]
        self.__doc__ = schema.manual(about)
        self.__signature__ = schema.signature(self._schema)

    def __call__(self, *positional: Any, **named: Any) -> Any:
        return self._call(self._name, schema.names_of(self._name, self._schema, positional, named))

    def __repr__(self) -> str:
        return f"<quiltd method {self._name}{self.__signature__}>"


class Group:
    """Methods whose names begin alike: q.camera has `set`, `orbit` and `fit`."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._methods: Dict[str, Method] = {}

    def __getattr__(self, name: str) -> Method:
        methods = self.__dict__.get("_methods", {})
        if name not in methods:
            meant = schema.did_you_mean(name, list(methods)) or "; it has " + ", ".join(methods)
            raise MethodNotFound(f"this quiltd has no method {self.__dict__.get('_name')}.{name}{meant}")
        return methods[name]

    def __dir__(self) -> List[str]:
        return sorted(self._methods)

    def __repr__(self) -> str:
        return f"<quiltd methods {self._name}: {', '.join(self._methods)}>"


def attributes(call: Call, methods: Dict[str, Dict[str, Any]]) -> Dict[str, Any]:
    """Per attribute of a client: a Method, or a Group."""
    found: Dict[str, Any] = {}
    for name, about in methods.items():
        group, _, rest = name.partition(".")
        method = Method(call, name, about)
        if rest:
            found.setdefault(group, Group(group))._methods[rest] = method
        else:
            found[name] = method
    return found
