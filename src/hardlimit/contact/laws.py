"""The contact laws: one class for each entry of ``core/contact/registry.hpp``. Their types are in ``laws.pyi``."""

from .. import _core
from .contact import Law, make_law

#: Contact laws by their names in files and on the command line.
LAWS: dict[str, type[Law]] = {record["name"]: make_law(record) for record in _core.law_records()}
globals().update({law.__name__: law for law in LAWS.values()})

__all__ = ["LAWS", *(law.__name__ for law in LAWS.values())]
