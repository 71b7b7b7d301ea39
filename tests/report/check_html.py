"""Reads an HTML page as strictly as the project needs and prints its tables as JSON.

Every element is closed in order, ids are unique, each table row has as many cells as its head has
columns. Exit code 1 and a line on stderr where not. An own judge: html.parser knows nothing of ours.
"""
import collections
import html.parser
import json
import sys

VOID = {"meta", "br", "hr", "img", "input", "link", "col", "wbr"}


class Checker(html.parser.HTMLParser):
    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open, self.ids, self.faults = [], collections.Counter(), []
        self.tables, self.cell, self.counts = {}, None, collections.Counter()
        self.doctype = None

    def handle_decl(self, decl):
        self.doctype = decl

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.counts[tag] += 1
        if len(values) != len(attributes):
            self.faults.append(f"line {self.getpos()[0]}: an attribute twice in <{tag}>")
        if "id" in values:
            self.ids[values["id"]] += 1
            self.last_id = values["id"]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "table":
            self.table = {"rows": [], "head": []}
            self.tables[self.last_id] = self.table
        elif tag == "tr":
            self.row = []
        elif tag in ("td", "th"):
            self.cell = []
            self.span = int(values.get("colspan", 1))

    def handle_endtag(self, tag):
        if not self.open or self.open[-1] != tag:
            self.faults.append(f"line {self.getpos()[0]}: </{tag}> closes {self.open[-3:]}")
            return
        self.open.pop()
        if tag in ("td", "th"):
            self.row.append(("".join(self.cell), self.span))
            self.cell = None
        elif tag == "tr":
            kind = "rows" if "tbody" in self.open else "head"
            self.table[kind].append([text for text, _ in self.row])
            if kind == "head" and len(self.table["head"]) == 1:
                self.table["width"] = sum(span for _, span in self.row)
            elif kind == "rows" and len(self.row) != self.table["width"]:
                self.faults.append(f"line {self.getpos()[0]}: a row of {len(self.row)} cells")

    def handle_data(self, data):
        if self.cell is not None:
            self.cell.append(data)


def main():
    checker = Checker()
    with open(sys.argv[1], encoding="utf-8") as page:
        checker.feed(page.read())
    checker.close()
    faults = checker.faults
    if checker.doctype != "doctype html":
        faults.append(f"doctype is {checker.doctype}")
    if checker.open:
        faults.append(f"never closed: {checker.open}")
    faults += [f"id {name} is there {n} times" for name, n in checker.ids.items() if n > 1]
    for fault in faults:
        print(fault, file=sys.stderr)
    json.dump({"tables": checker.tables, "counts": checker.counts}, sys.stdout)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
