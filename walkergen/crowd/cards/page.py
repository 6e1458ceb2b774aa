"""Page of a card: one HTML file with its tables, notes and figure, that loads nothing."""

import base64
from html import escape

from walkergen.crowd.cards.report import CardReport

STYLE = (
    "body{font:16px/1.4 sans-serif;max-width:46em;margin:2em auto;padding:0 1em;color:#222}"
    "table{border-collapse:collapse;margin:1em 0}td{padding:.2em .8em .2em 0;"
    "border-bottom:1px solid #ddd;vertical-align:top}img{max-width:100%}h2{font-size:1.1em}"
)


def html(report: CardReport, pictures: bool) -> bytes:
    """Page of a report; with its figure if `pictures` are wanted."""
    parts = [f"<h1>{escape(report.title)}</h1><p>{escape(report.caption)}</p>"]
    for table in report.shown():
        rows = [[column.cell(row) for column in table.columns] for row in table.rows]
        cells = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
        parts.append(f"<h2>{escape(table.title)}</h2><table>{cells}</table>")
    if pictures:
        parts += [_picture(name, report) for name in report.figures]
    parts += [f"<p>{escape(line)}</p>" for line in report.lines]
    head = f'<meta charset="utf-8"><title>{escape(report.title)}</title><style>{STYLE}</style>'
    body = "".join(parts)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>{body}</body></html>\n'.encode()


def _picture(name: str, report: CardReport) -> str:
    from walkergen.files import figures  # brings matplotlib

    data = base64.b64encode(figures.png(report.figures[name]())).decode()
    return f'<img alt="{escape(report.title)}: figure" src="data:image/png;base64,{data}">'
