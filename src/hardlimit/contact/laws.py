"""The contact laws: one class for each entry of ``core/contact/registry.hpp``. Their types are in ``laws.pyi``."""

from .. import _core
from ..support import validation
from .contact import Law, make_law

#: What the refusal of a Python class of a law says.
ADD_A_LAW = "a law is two files of C++: CONTRIBUTING.md, 'Add a law'"

#: Contact laws by their names in files and on the command line.
LAWS: dict[str, type[Law]] = {record["name"]: make_law(record) for record in _core.law_records()}
validation.sealed(ADD_A_LAW)(Law)
globals().update({law.__name__: law for law in LAWS.values()})

__all__ = ["LAWS", *(law.__name__ for law in LAWS.values())]
