"""The console's page in headless Firefox: pictures come as JPEG, where Firefox decodes no H.264 here."""

import pathlib

from selenium import webdriver

from page import Page, installed
from process import ends


class FirefoxPage(Page):
    """A console in headless Firefox."""

    def __init__(self, url: str, folder: pathlib.Path, size: tuple[int, int]) -> None:
        self.profile = folder / "firefox"
        self.profile.mkdir()
        options = webdriver.FirefoxOptions()
        options.binary_location = installed("firefox-esr", "firefox", needs="firefox")
        options.add_argument("-headless")
        service = webdriver.FirefoxService(installed("geckodriver", needs="firefox"))
        self.driver = webdriver.Firefox(options, service)  # type: ignore[assignment]
        self.is_open = True
        ends.append(self.end)
        self.resize(*size)
        self.driver.get(url)

    def resize(self, width: int, height: int) -> None:
        """Gives the window a size that leaves this much for the page."""
        self.driver.set_window_size(width, height)
        inner = self.script("return [innerWidth, innerHeight]")
        self.driver.set_window_size(2 * width - inner[0], 2 * height - inner[1])

    def complaints(self) -> list[str]:
        # Firefox has no log for its driver.
        return []
