# SPDX-License-Identifier: Apache-2.0
"""What several entries have in common."""
from harness import Entry, Step, Value
from meshes import use


def hours(text):
    """Seconds of H:MM:SS."""
    h, m, s = (int(part) for part in text.split(":"))
    return 3600 * h + 60 * m + s


def growth(size, small="24,32,40,48", medium="50,70,100,140", full="100,200,400,800"):
    return size.pick(small, medium, full)


def dimension(label, command, resolutions):
    """A step that measures the dimension of the surface."""
    return Step(label, f"juliavdb study {command} --dimension {resolutions} --json")


def dimension_values(case, output, paper=None, compared=True):
    law = output.json()
    return [Value(case, "dimension", law["dimension"], paper, compared), Value(case, "standard error", law["standardError"])]


def gallery(name, paper, figures, small, published, remarks):
    """The figures of a paper, by the commands of docs/gallery.md. A small run makes those of `small` alone.

    @param published  figure -> what the paper says of it, in words"""
    def chosen(size):
        return size.pick(small, figures, figures)

    def steps(size):
        option = "--bunny $bunny --dragon $dragon " + size.pick("--small ", "", "")
        return [Step(figure, f"docs/make-gallery {option}--into . {figure}") for figure in chosen(size)]

    def table(outputs, size):
        return [value for figure in chosen(size) for value in (
            Value(published[figure][0], "pictures", f"{figure}*.png", published[figure][1]),
            Value(published[figure][0], "CPU s", outputs[figure].cpu))]

    return Entry(name, paper, "Figures", "as docs/gallery.md makes them", steps, table, ("bunny", "dragon"), (), remarks)
