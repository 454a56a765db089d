# SPDX-License-Identifier: Apache-2.0
"""The tables of results as CSV and as Markdown, and the page of all of them."""
import csv
import io


def text(value):
    """A number as the pages have it: whole ones in groups of three, others with four digits."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float) and value.is_integer() and abs(value) >= 1e4:
        value = int(value)
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ") if abs(value) >= 10000 else str(value)
    if isinstance(value, float):
        if abs(value) >= 1e4:
            return f"{round(value):,}".replace(",", " ")
        return f"{value:.0f}" if abs(value) >= 1e3 else f"{value:.4g}"
    return str(value).replace("|", "\\|")


def as_csv(values):
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(["case", "quantity", "paper", "ours", "ratio"])
    for value in values:
        writer.writerow([value.case, value.quantity, "" if value.paper is None else value.paper, value.ours,
                         "" if value.ratio is None else f"{value.ratio:.6g}"])
    return file.getvalue()


def as_markdown(values):
    """A row for each case. A quantity has a column of ours and, where the paper has it, one of the paper's and one of the ratio."""
    cases = list(dict.fromkeys(value.case for value in values))
    quantities = list(dict.fromkeys(value.quantity for value in values))
    found = {(value.case, value.quantity): value for value in values}
    columns = []
    for quantity in quantities:
        of = [value for value in values if value.quantity == quantity]
        columns.append((quantity, lambda value: text(value.ours)))
        if any(value.paper is not None for value in of):
            columns.append(("paper", lambda value: text(value.paper)))
        if any(value.ratio is not None for value in of):
            columns.append(("ratio", lambda value: text(value.ratio)))
    lines, quantity = ["| case |", "|---|"], None
    for head, _ in columns:
        lines[0] += f" {head} |"
        lines[1] += "--:|"
    for case in cases:
        line, quantity = f"| {text(case)} |", None
        for head, show in columns:
            quantity = head if head not in ("paper", "ratio") else quantity
            value = found.get((case, quantity))
            line += f" {show(value) if value else ''} |"
        lines.append(line)
    return "\n".join(lines) + "\n"
