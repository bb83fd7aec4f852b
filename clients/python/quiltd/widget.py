"""A quilt in a notebook: plain HTML and JavaScript, which works without a running quiltd, too."""

import base64
import uuid
from typing import Any, Dict, Tuple


class Preview(bytes):
    """The bytes of a JPEG quilt. info: the answer of frame.get, with columns, rows, views, width and height."""

    info: Dict[str, Any]

    def __new__(cls, data: bytes, info: Dict[str, Any]) -> "Preview":
        preview = super().__new__(cls, data)
        preview.info = info
        return preview

    def _repr_jpeg_(self) -> bytes:
        return bytes(self)


def place(view: int, columns: int, rows: int) -> Tuple[float, float]:
    """CSS background-position of a view, in percent: view 0 is at the bottom left of the quilt, percents count from the top."""
    column, row = view % columns, rows - 1 - view // columns
    return 100 * column / max(columns - 1, 1), 100 * row / max(rows - 1, 1)


_PAGE = """<div id="{id}" role="slider" tabindex="0" aria-label="views" aria-valuemin="0" aria-valuemax="{last}" aria-valuenow="{middle}"
 style="width:{width}px;max-width:100%;aspect-ratio:{view_width}/{view_height};cursor:ew-resize;touch-action:pan-y;
background:url(data:image/jpeg;base64,{jpeg}) {x}% {y}% / {columns}00% {rows}00%"></div>
<script>
(() => {{
  const box = document.getElementById("{id}"), columns = {columns}, rows = {rows}, views = {views};
  let view = {middle};
  const show = (wanted) => {{
    view = Math.min(views - 1, Math.max(0, wanted));
    const x = 100 * (view % columns) / Math.max(columns - 1, 1);
    const y = 100 * (rows - 1 - Math.floor(view / columns)) / Math.max(rows - 1, 1);
    box.style.backgroundPosition = x + "% " + y + "%";
    box.setAttribute("aria-valuenow", view);
  }};
  box.addEventListener("pointermove", (event) => {{
    const place = box.getBoundingClientRect();
    show(Math.floor((event.clientX - place.left) / place.width * views));
  }});
  box.addEventListener("keydown", (event) => {{
    const step = {{ ArrowLeft: -1, ArrowRight: 1 }}[event.key];
    if (step) {{ show(view + step); event.preventDefault(); }}
  }});
}})();
</script>"""


class Widget:
    """What Jupyter shows of a preview: the view under the pointer. Without JavaScript it is the middle view."""

    def __init__(self, preview: Preview, width: int) -> None:
        self.preview = preview
        self.width = width

    def _repr_html_(self) -> str:
        info = self.preview.info
        columns, rows, views = int(info["columns"]), int(info["rows"]), int(info["views"])
        x, y = place(views // 2, columns, rows)
        return _PAGE.format(
            id="quiltd-" + uuid.uuid4().hex,
            jpeg=base64.b64encode(self.preview).decode(),
            width=self.width,
            view_width=int(info["width"]),
            view_height=int(info["height"]),
            columns=columns,
            rows=rows,
            views=views,
            last=views - 1,
            middle=views // 2,
            x=f"{x:g}",
            y=f"{y:g}",
        )
