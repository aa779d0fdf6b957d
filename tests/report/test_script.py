"""What the page's script does, in a browser: reads, zooms, hides and saves."""

from __future__ import annotations

import html as entities
import json
import re
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from motorid.report import html
from tests.report.example import estimate
from tests.report.test_screenshot import QUIET, browser

__all__ = ["browser"]  # a fixture

TRIAL = """
<pre id="heard"></pre><script>
const heard = {};
const plot = document.querySelector(".run .plot");
const frame = plot.querySelector(".frame"), svg = plot.querySelector("svg");
const labels = () => [...plot.parentElement.querySelectorAll(".xs span")].map((s) => s.textContent);
const at = (kind, share) => {
  const box = frame.getBoundingClientRect();
  const event = { clientX: box.left + share * box.width, bubbles: true };
  frame.dispatchEvent(new PointerEvent(kind, event));
};
at("pointermove", 0.5);
heard.read = frame.querySelector(".readout").textContent;
heard.labels = labels();
at("pointerdown", 0.25); at("pointerup", 0.5);
heard.zoomed = [svg.getAttribute("viewBox"), labels()];
const whole = [...plot.closest(".run").children].filter((one) => one.tagName === "FIGURE");
const all = whole.flatMap((one) => [...one.querySelectorAll(".plot svg")]);
heard.linked = all.map((one) => one.getAttribute("viewBox").split(" ")[0]);
frame.dispatchEvent(new MouseEvent("dblclick", { bubbles: true }));
heard.whole = [svg.getAttribute("viewBox"), labels()];
plot.closest(".run").querySelector(".legend button").click();
heard.hidden = getComputedStyle(svg.querySelector("path.measured")).display;
at("pointermove", 0.5);
heard.alone = frame.querySelector(".readout").textContent;
let saved = "";
URL.createObjectURL = (blob) => { saved = blob; return "data:,"; };
HTMLAnchorElement.prototype.click = () => {};
plot.closest("figure").querySelector("figcaption button").click();
saved.text().then((text) => {
  heard.saved = text.split("\\n").slice(0, 3);
  document.getElementById("heard").textContent = JSON.stringify(heard);
});
</script></main>"""


@cache
def heard(program: str, folder: Path) -> dict[str, Any]:
    """What the trial heard in the page, which runs it besides its own script."""
    page = html.render(estimate())
    page = re.sub(r"script-src '[^']*'", "script-src 'unsafe-inline'", page)
    own = page.index("<script>")
    trial = TRIAL.replace("</main>", "")
    end = page.index("</script>", own) + len("</script>")
    (folder / "page.html").write_text(page[:end] + trial + page[end:], encoding="utf-8")
    done = subprocess.run(
        [program, *QUIET, f"--user-data-dir={folder / 'profile'}", "--window-size=1200,1600",
         "--virtual-time-budget=3000", "--dump-dom", (folder / "page.html").as_uri()],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert "CONSOLE" not in done.stderr
    found = re.search(r'<pre id="heard">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found, done.stdout[-500:]
    answer: dict[str, Any] = json.loads(entities.unescape(found[1]))
    return answer


@pytest.fixture(scope="module")
def told(browser: str, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return heard(browser, tmp_path_factory.mktemp("script"))


@pytest.mark.slow
def test_a_pointer_reads_both_curves(told: dict[str, Any]) -> None:
    number = r"−?[0-9.]+"
    assert re.fullmatch(rf"{number} s: measured {number}; fitted {number} A", told["read"])


@pytest.mark.slow
def test_a_drag_zooms_all_plots_of_a_run_and_a_double_click_undoes_it(told: dict[str, Any]) -> None:
    box, labels = told["zoomed"]
    assert [float(x) for x in box.split()][::2] == pytest.approx([250.0, 250.0], abs=1.0)
    assert labels != told["labels"]
    assert len(told["linked"]) == 4  # two channels and their residuals
    assert len(set(told["linked"])) == 1
    assert told["whole"] == ["0 0 1000 1000", told["labels"]]


@pytest.mark.slow
def test_a_curve_can_be_hidden(told: dict[str, Any]) -> None:
    assert told["hidden"] == "none"
    assert "measured" not in told["alone"]


@pytest.mark.slow
def test_the_points_of_a_plot_can_be_saved(told: dict[str, Any]) -> None:
    head, first, _ = told["saved"]
    assert head == 'line,"time, s",value'
    assert first.startswith('"fitted: current, A",')  # what is hidden is left out
