"""The JPEG quilt of frame.get, and the HTML that turns it."""

import base64
import html.parser
import os
import re
import shutil
import subprocess
import unittest

from fake import FakeCase
from quiltd.widget import Preview, Widget, place

INFO = {"generation": 3, "format": "jpeg", "columns": 3, "rows": 2, "views": 5, "width": 30, "height": 40, "bytes": 4}


class Tags(html.parser.HTMLParser):
    def __init__(self, page):
        super().__init__()
        self.box, self.script = {}, ""
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        if tag == "div":
            self.box = dict(attrs)

    def handle_data(self, data):
        self.script += data


class Previews(FakeCase):
    def test_the_daemon_writes_the_picture(self):
        self.fake.answers["frame.get"] = lambda params, files: os.write(files[0], b"JPEG") and INFO
        preview = self.q.preview(width=30, quality=60)
        self.assertEqual((preview, preview.info["columns"]), (b"JPEG", 3))
        self.assertEqual(self.q.preview(width=None), b"JPEG")
        self.fake.answers["status"] = lambda params, files: {"view_width": 24}
        self.q.preview(width=30)
        jpeg = {"format": "jpeg"}
        self.assertEqual(self.sent("frame.get"), [{**jpeg, "width": 30, "quality": 60}, jpeg, {**jpeg, "width": 24}])

    def test_a_widget_is_of_the_picture(self):
        self.fake.answers["frame.get"] = lambda params, files: os.write(files[0], b"JPEG") and INFO
        self.assertIn(base64.b64encode(b"JPEG").decode(), self.q.widget(width=100)._repr_html_())
        self.assertEqual(self.sent("frame.get"), [{"format": "jpeg", "width": 100}])


class Pages(unittest.TestCase):
    def setUp(self):
        self.page = Tags(Widget(Preview(b"JPEG", INFO), 100)._repr_html_())

    def test_view_0_is_at_the_bottom_left(self):
        self.assertEqual([place(view, 3, 2) for view in (0, 2, 3, 5)], [(0, 100), (100, 100), (0, 0), (100, 0)])
        self.assertEqual(place(0, 1, 1), (0, 0))

    def test_without_javascript_the_middle_view_is_shown(self):
        self.assertIn(") 100% 100% / 300% 200%", self.page.box["style"])
        self.assertIn("aspect-ratio:30/40", self.page.box["style"])
        self.assertEqual((self.page.box["aria-valuenow"], self.page.box["aria-valuemax"]), ("2", "4"))

    def test_pages_have_different_boxes(self):
        self.assertNotEqual(Tags(Widget(Preview(b"", INFO), 1)._repr_html_()).box["id"], self.page.box["id"])

    @unittest.skipUnless(shutil.which("node"), "there is no node")
    def test_pointer_and_keys_turn_it(self):
        browser = """
const handlers = {}, style = {}, shown = [];
const box = { style, addEventListener: (name, f) => { handlers[name] = f; }, setAttribute: (name, value) => shown.push(value),
    getBoundingClientRect: () => ({ left: 10, width: 100 }) };
globalThis.document = { getElementById: () => box };
%s
for (const clientX of [-50, 10, 35, 109, 400]) handlers.pointermove({ clientX });
for (const key of ["ArrowLeft", "ArrowRight", "ArrowRight", "x"]) handlers.keydown({ key, preventDefault() {} });
handlers.pointermove({ clientX: 75 });
console.log(JSON.stringify([shown, style.backgroundPosition]));
"""
        run = subprocess.run(["node", "-"], input=browser % self.page.script, capture_output=True, text=True, check=True)
        x, y = place(3, 3, 2)
        self.assertEqual(run.stdout.strip(), f'[[0,0,1,4,4,3,4,4,3],"{x:g}% {y:g}%"]')

    def test_it_loads_nothing_from_elsewhere(self):
        self.assertIsNone(re.search(r"https?:|src=|import", self.page.script + str(self.page.box)))


if __name__ == "__main__":
    unittest.main()
