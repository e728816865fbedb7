"""HTML tables for notebooks."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape


def table(caption: str, head: Sequence[str], rows: Sequence[Sequence[str]], below: str = "") -> str:
    """An HTML table with the first column left-aligned and the others right-aligned; all text is escaped."""
    parts = ["<table>", f'<caption style="text-align: left">{escape(caption)}</caption>']
    if any(head):
        parts.append(f"<thead><tr>{''.join(f'<th>{escape(name)}</th>' for name in head)}</tr></thead>")
    parts.append("<tbody>")
    for first, *rest in rows:
        cells = "".join(f'<td style="text-align: right">{escape(text)}</td>' for text in rest)
        parts.append(f'<tr><th style="text-align: left">{escape(first)}</th>{cells}</tr>')
    parts.append("</tbody></table>")
    if below:
        parts.append(f"<p>{escape(below)}</p>")
    return "".join(parts)
