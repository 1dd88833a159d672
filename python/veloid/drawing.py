"""Reports in notebooks."""

from __future__ import annotations

from html import escape
from typing import Any

from . import _native

METHODS = {
    "least_squares": "least squares",
    "instrumental": "instrumental",
    "swarm": "swarm",
    "output_error": "output error",
    "latent_road": "latent road",
    "extended": "extended",
}
KINDS = (("k_n_m", "k_std_n_m", "k (N/m)"), ("b_n_s_m", "b_std_n_s_m", "B (N s/m)"))
WIDE = 1.96
"""Half width of a 95 % interval in standard errors."""
WIDTH, LINE, LABEL, EDGE = 640, 20, 110, 12
"""Of a figure (px): its width, the height of a line, the margin for names on the left and the empty margin on the right."""


def page(parts: list[str]) -> str:
    return f'<div style="max-width:50em">{"".join(parts)}</div>'


def report(document: dict[str, Any]) -> list[str]:
    """The verdict, the warnings, k and B by every method."""
    ride = document["ride"]
    warnings = [*ride["warnings"], *(mistake["sentence"] for mistake in document["mistakes"])]
    parts = [] if document["diagnosis"] is None else diagnosis(document["diagnosis"])
    parts.append(answer(document.get("result", {})))
    parts += [f"<p>Warning: {escape(warning)}</p>" for warning in warnings]
    rows = estimates(document)
    parts.append(numbers(rows))
    parts += [figure(rows, axle, kind) for axle in ("front", "rear") for kind in KINDS]
    size = f"{ride['samples']} samples, {ride['duration_s']:.4g} s at {ride['rate_hz']:.5g} Hz"
    parts.append(f"<p><small>{size}. ± is the 95 % interval; the swarm has none. veloid {escape(document['veloid'])}</small></p>")
    return parts


def answer(result: dict[str, Any]) -> str:
    """k, B and mass of each axle, with intervals."""

    def cell(found: dict[str, Any]) -> str:
        if found["value"] is None:
            return f"withheld: {escape(found['why'])}"
        error = found["std_error"]
        value = _native.measured(found["value"], error)
        note = "" if error is not None else f" ({escape(found['why'])})"
        return f"{value} {escape(found['unit'])}{note}"

    rows = [[axle, name, cell(found)] for axle, all in result.items() for name, found in (all or {}).items()]
    return table(["axle", "quantity", "result"], rows)


def diagnosis(document: dict[str, Any]) -> list[str]:
    """The verdict's sentence, and each effect with its parameters."""
    parts = [f"<p><b>{escape(document['sentence'])}</b></p>"]
    rows = []
    for effect in document["effects"]:
        for name, parameter in effect["parameters"].items():
            # A side is a choice, given by its unit.
            told = "" if name == "side" else _native.measured(parameter["value"], parameter["std_error"])
            sure = "" if effect["affirmed"] else " (not affirmed)"
            rows.append([effect["id"] + sure, effect["axle"], name, f"{told} {parameter['unit']}".strip()])
    if rows:
        parts.append(table(["effect", "axle", "parameter", ""], rows))
    return parts


def estimates(document: dict[str, Any]) -> list[tuple[str, str, dict[str, Any]]]:
    """Method, axle and estimate, in the order in which the methods run."""
    sections = {method: document.get(method) or {} for method in METHODS}
    sections["extended"] = (document["diagnosis"] or {}).get("extended", {})
    return [
        (method, axle, section[axle])
        for method, section in sections.items()
        for axle in ("front", "rear")
        if section.get(axle) is not None
    ]


def numbers(rows: list[tuple[str, str, dict[str, Any]]]) -> str:
    cells = [
        [METHODS[method], axle, *(_native.measured(found[name], found[error]) for name, error, _ in KINDS)]
        for method, axle, found in rows
    ]
    return table(["method", "axle", *(label for _, _, label in KINDS)], cells)


def table(head: list[str], rows: list[list[str]]) -> str:

    def cells(row: list[str], tag: str) -> str:
        return "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row)

    body = "".join(f"<tr>{cells(row, 'td')}</tr>" for row in rows)
    return f"<table><thead><tr>{cells(head, 'th')}</tr></thead><tbody>{body}</tbody></table>"


def figure(rows: list[tuple[str, str, dict[str, Any]]], axle: str, kind: tuple[str, str, str]) -> str:
    """One parameter of one axle: a dot for each method, a line for its interval."""
    name, error, label = kind
    found = [(METHODS[m], float(e[name]), WIDE * float(e[error] or 0.0)) for m, a, e in rows if a == axle]
    if not found:
        return ""
    low = min(value - margin for _, value, margin in found)
    high = max(value + margin for _, value, margin in found)
    span = (high - low) or abs(high) or 1.0

    def at(value: float) -> float:
        return LABEL + (WIDTH - LABEL - EDGE) * (value - low) / span

    height = LINE * (len(found) + 1)
    ends = " to ".join(_native.measured(end, None) for end in (low, high))
    marks = [f'<text x="0" y="14" font-weight="bold">{axle}: {escape(label)}, {ends}</text>']
    for i, (method, value, margin) in enumerate(found):
        y = LINE * (i + 1.5)
        marks.append(f'<text x="0" y="{y + 4:.0f}">{method}</text>')
        marks.append(f'<line x1="{at(value - margin):.1f}" x2="{at(value + margin):.1f}" y1="{y}" y2="{y}"/>')
        marks.append(f'<circle cx="{at(value):.1f}" cy="{y}" r="3.5"/>')
    style = "font:12px sans-serif;fill:currentColor;stroke-width:2"
    title = f"{axle}: {escape(label)} by method"
    body = "".join(marks).replace("<line", '<line stroke="currentColor"')
    return f'<svg role="img" aria-label="{title}" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" style="{style}">{body}</svg>'
