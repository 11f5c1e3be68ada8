"""A real `grex view` beside a real run, and what a test needs to look at its page."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from launching import grex

#: A run whose messages are short, many and often lost.
LIVELY = (
    "--pace", "live", "--set", "clock.tick_s=0.1", "--set", "duration_s=600", "--set", "link.profile=s2c_im",
    "--set", "link.burst={loss=0.5,mean_length_s=4}",
)  # fmt: skip


@contextmanager
def viewing(*arguments: str) -> Iterator[str]:
    """Start `grex view` on a free port; the address of its page."""
    process = subprocess.Popen(
        grex("view", *arguments, "--port", "0"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        address = process.stdout.readline().strip()
        assert address.startswith("http://127.0.0.1:"), process.stderr.read()
        yield address
    finally:
        process.terminate()
        _, said = process.communicate(timeout=10)
        assert said == ""
        assert process.returncode in {0, 130}


#: How many pixels of a canvas have about this colour and at least this opacity, and their middle: [count, x, y].
PIXELS = """([id, red, green, blue, least]) => {
  const canvas = document.getElementById(id);
  const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let [count, x, y] = [0, 0, 0];
  for (let place = 0; place < data.length; place += 4) {
    if (data[place + 3] < least) continue;
    if (Math.abs(data[place] - red) + Math.abs(data[place + 1] - green) + Math.abs(data[place + 2] - blue) < 24) {
      count += 1; x += (place / 4) % width; y += Math.floor(place / 4 / width);
    }
  }
  return [count, x / Math.max(count, 1), y / Math.max(count, 1)];
}"""
#: Colours with their least opacity: craft are painted, plan and track shine through.
AUV1 = [0, 114, 178, 240]
LOST = [194, 65, 12, 100]


def pixels(page, colour, canvas="plan"):
    """Count and middle of a canvas' pixels of a colour."""
    return page.evaluate(PIXELS, [canvas, *colour])


def cell(page, name, column):
    """Figure of a craft in the table of craft."""
    text = page.locator(f"#craft tr[data-name={name}] td").nth(column).inner_text()
    return float(text.replace("−", "-"))
