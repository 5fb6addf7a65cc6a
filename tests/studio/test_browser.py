"""The browser that drives the page in tests draws in three dimensions, without a screen."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Page


def test_the_browser_draws(page: Page):
    pixel = page.evaluate(
        """() => {
          const gl = document.createElement("canvas").getContext("webgl2");
          gl.clearColor(1, 0.2, 0, 1);
          gl.clear(gl.COLOR_BUFFER_BIT);
          const pixel = new Uint8Array(4);
          gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
          return Array.from(pixel);
        }"""
    )
    assert pixel == [255, 51, 0, 255]
