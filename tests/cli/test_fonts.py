# SPDX-License-Identifier: Apache-2.0
"""Text in pictures is set in the program's own font: neither the fonts of a machine nor its settings change a byte."""

import os
import pathlib
import re
import unittest

import harness

LOW = ("--size", 24, "--sdf-resolution", 16)
FONTS = pathlib.Path("/usr/share/fonts")

# Other fonts under the names that programs ask for, and other letters of each.
HOSTILE = """<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig>
  <dir>{fonts}</dir>
  <cachedir>{cache}</cachedir>
  <match target="pattern"><edit name="family" mode="assign" binding="strong"><string>{family}</string></edit></match>
  <match target="font">
    <edit name="antialias" mode="assign"><bool>false</bool></edit>
    <edit name="hinting" mode="assign"><bool>true</bool></edit>
    <edit name="hintstyle" mode="assign"><const>hintfull</const></edit>
    <edit name="autohint" mode="assign"><bool>true</bool></edit>
    <edit name="embolden" mode="assign"><bool>true</bool></edit>
    <edit name="matrix" mode="assign"><times><name>matrix</name>
      <matrix><double>1</double><double>0.4</double><double>0</double><double>1</double></matrix></times></edit>
  </match>
</fontconfig>
"""
NONE = """<?xml version="1.0"?>
<!DOCTYPE fontconfig SYSTEM "fonts.dtd">
<fontconfig><dir>{nothing}</dir><cachedir>{cache}</cachedir></fontconfig>
"""


class Fonts(harness.CliTest):

    def machines(self):
        """Environments in which Fontconfig and FreeType would choose otherwise."""
        self.path("nothing").mkdir()
        self.write("none.conf", NONE.format(nothing=self.path("nothing"), cache=self.path("cache")))
        self.write("hostile.conf", HOSTILE.format(fonts=FONTS, cache=self.path("cache"), family="DejaVu Sans Mono"))
        return {
            "no fonts": {"FONTCONFIG_FILE": str(self.path("none.conf"))},
            "another font": {"FONTCONFIG_FILE": str(self.path("hostile.conf"))},
            "a user without a home": {"HOME": str(self.path("nothing")), "XDG_CACHE_HOME": "", "XDG_CONFIG_HOME": ""},
            "FreeType's settings": {
                "FREETYPE_PROPERTIES": "autofitter:no-stem-darkening=0 autofitter:default-script=cyrl "
                                       "cff:no-stem-darkening=0 truetype:interpreter-version=35"},
        }

    def same(self, outputs, *arguments):
        self.ok(*arguments)
        wanted = {name: self.bytes(name) for name in outputs}
        for machine, env in self.machines_.items():
            with self.subTest(machine=machine, command=arguments[0]):
                said = self.ok(*arguments, env=env)
                self.assertNotIn("Fontconfig", said)
                for name in outputs:
                    self.assertTrue(self.bytes(name) == wanted[name], f"the bytes of {name} differ")

    def setUp(self):
        super().setUp()
        self.machines_ = self.machines()
        self.write("s.obj", harness.obj(harness.sphere(2)))

    # Promise of design.md: "Text in pictures is set in DejaVu Sans, which is a part of the library", whatever fonts are
    #   installed; "A character that the font lacks is drawn as a box"
    def test_plots_and_sheets(self):
        for kind in ("svg", "png"):
            curve = f"c.{kind}"
            self.same(["a.png", curve], "study", "s.obj", "-o", "a.png", "--curve", curve, "--versors", 2, *LOW)
        self.same(["s.png"], "sheet", "s.obj", "-o", "s.png", "--vary", "detail=0.1,0.3", "--size", "16x16", "--samples", 1,
                  "--sdf-resolution", 16)

    # Promise: "Text in pictures is set ..."
    def test_no_font_is_opened(self):
        """With no fonts at all a plot has letters."""
        self.ok("study", "s.obj", "-o", "a.png", "--curve", "c.svg", "--versors", 2, *LOW, env=self.machines_["no fonts"])
        texts = re.findall(r'aria-label="([^"]+)"[^>]* d="([^"]+)"', self.bytes("c.svg").decode())
        self.assertGreater(len(texts), 8)
        for text, path in texts:
            # Every letter but a blank has one contour at least.
            self.assertGreaterEqual(path.count("M"), len(text.replace(" ", "")), text)


if __name__ == "__main__":
    harness.main()
