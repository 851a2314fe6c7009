# SPDX-License-Identifier: GPL-3.0-or-later
"""The guide as pages that a browser shows without a network: what F1 and Preferences open. Plain Python, no packages.

    manual_page.py FOLDER     writes them, with the pictures that they show
"""

import html
import itertools
import pathlib
import posixpath
import re
import sys

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PAGES = ("index", "troubleshooting", *sorted(f"guide/{page.stem}" for page in (DOCS / "guide").glob("*.md")))

STYLE = """body{max-width:52rem;margin:2rem auto;padding:0 1rem;font:16px/1.5 sans-serif;color:#222;background:#fff}
img{max-width:100%}table{border-collapse:collapse}td,th{border:1px solid #bbb;padding:.3rem .6rem;text-align:left}
pre{background:#eee;padding:.7rem;overflow:auto}code{background:#eee}nav a{margin-right:.9rem}
@media(prefers-color-scheme:dark){body{color:#ddd;background:#222}pre,code{background:#333}a{color:#8bf}}"""

LIST = re.compile(r"(\*|\d+\.) +")


def files():
    """{path in the manual: bytes}"""
    found, pictures = {}, set()
    for name in PAGES:
        text = (DOCS / f"{name}.md").read_text("utf-8")
        found[f"{name}.html"] = page(name, text).encode()
        pictures |= {posixpath.normpath(posixpath.join(posixpath.dirname(name), each)) for each in shown(text)}
    return found | {path: (DOCS / path).read_bytes() for path in sorted(pictures)}


def shown(text):
    """Targets of pictures."""
    return re.findall(r"!\[[^]]*\]\(([^)]+)\)", text)


def page(name, text):
    up = posixpath.relpath(".", posixpath.dirname(name) or ".")
    links = (f'<a href="{posixpath.join(up, each)}.html">{title(each)}</a>' for each in PAGES)
    head = f"<meta charset=utf-8><meta name=viewport content='width=device-width'><title>{title(name)}</title>"
    body = "\n".join(blocks(text.splitlines(), posixpath.dirname(name)))
    return f"<!doctype html>{head}<style>{STYLE}</style>\n<nav>{' '.join(links)}</nav>\n{body}\n"


def title(name):
    return html.escape((DOCS / f"{name}.md").read_text("utf-8").splitlines()[0].lstrip("# "))


def blocks(lines, folder):
    """Yields HTML of lines of Markdown, as far as the guide uses it."""
    while lines:
        line, count = lines[0], 1
        if line.startswith("```"):
            count = lines.index("```", 1) + 1
            yield f"<pre>{html.escape(chr(10).join(lines[1 : count - 1]))}</pre>"
        elif line.startswith("#"):
            level, words = len(line) - len(line.lstrip("#")), line.lstrip("# ")
            anchor = re.sub(r"[^\w -]", "", words.lower()).replace(" ", "-")
            yield f'<h{level} id="{anchor}">{inline(words, folder)}</h{level}>'
        elif line.startswith("|"):
            count = length(lines, lambda each: each.startswith("|"))
            rows = [row.strip("|").split("|") for row in lines[:count] if not set(row) <= set("|-: ")]
            yield "<table>"
            yield from (table_row(row, folder, "td" if number else "th") for number, row in enumerate(rows))
            yield "</table>"
        elif LIST.match(line):
            count = length(lines, lambda each: not each or each.startswith(" ") or LIST.match(each))
            yield from a_list(lines[:count], folder)
        elif line:
            count = max(length(lines, lambda each: each and not LIST.match(each) and each[0] not in "|#"), 1)
            yield f"<p>{inline(' '.join(lines[:count]), folder)}</p>"
        lines = lines[count:]


def length(lines, belongs):
    return next((number for number, line in enumerate(lines) if not belongs(line)), len(lines))


def a_list(lines, folder):
    tag = "ul" if lines[0].startswith("*") else "ol"
    starts = [number for number, line in enumerate(lines) if LIST.match(line)] + [len(lines)]
    yield f"<{tag}>"
    for begin, end in itertools.pairwise(starts):
        first = LIST.sub("", lines[begin], count=1)
        rest = lines[begin + 1 : end]
        own = length(rest, lambda line: line and not LIST.match(line.strip()))
        words = " ".join([first, *(line.strip() for line in rest[:own])])
        yield f"<li>{inline(words, folder)}"
        yield from blocks([line.strip() for line in rest[own:]], folder)
        yield "</li>"
    yield f"</{tag}>"


def table_row(cells, folder, tag):
    return "<tr>" + "".join(f"<{tag}>{inline(cell.strip(), folder)}</{tag}>" for cell in cells) + "</tr>"


def inline(text, folder):
    """Words with their links, pictures and emphasis; what is in `code` stays as it is."""
    parts = re.split(r"(`[^`]*`)", text)
    for number, part in enumerate(parts):
        if number % 2:
            parts[number] = f"<code>{html.escape(part[1:-1]).replace('*', '&#42;')}</code>"
        else:
            parts[number] = re.sub(
                r"!\[([^]]*)\]\(([^)]+)\)", r'<img alt="\1" src="\2">', html.escape(part, quote=False)
            )
    text = "".join(parts)
    text = re.sub(r"\[([^]]+)\]\(([^)]+)\)", lambda found: link(*found.groups(), folder), text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", text)
    return re.sub(r"\*([^*]+)\*", r"<i>\1</i>", text)


def link(words, target, folder):
    """Words alone where the page is not in the manual."""
    path, _, anchor = target.partition("#")
    stem = posixpath.normpath(posixpath.join(folder, path)).removesuffix(".md")
    if "://" not in target and path and stem not in PAGES:
        return words
    return f'<a href="{re.sub(r"[.]md$", ".html", path)}{"#" + anchor if anchor else ""}">{words}</a>'


if __name__ == "__main__":
    for path, content in files().items():
        where = pathlib.Path(sys.argv[1], path)
        where.parent.mkdir(parents=True, exist_ok=True)
        where.write_bytes(content)
