# SPDX-License-Identifier: Apache-2.0
"""What the tests in a real browser share: Chromium without a display, with software for a GPU."""

import shutil
import sys
import tempfile

from server import harness

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.options import Options
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    webdriver = None

PATIENCE = 120  # seconds


def missing():
    if webdriver is None:
        return "python3-selenium"
    return next((name for name in ("chromium", "chromedriver") if not shutil.which(name)), None)


def main():
    """Runs the tests of the script, or says what they need."""
    if missing():
        print(f"skipped: {missing()} is not installed")
        sys.exit(0)
    harness.main()


class BrowserTest(harness.CliTest):
    # Of the layout, and how many pixels the screen has for each of these. Software draws some thousand a second.
    WIDTH, HEIGHT, SCALE = 800, 400, 0.3
    LOGS = {"browser": "ALL"}

    @classmethod
    def setUpClass(cls):
        """One browser for all tests of the class; each test has a tab of its own."""
        super().setUpClass()
        profile = tempfile.TemporaryDirectory(prefix="profile", ignore_cleanup_errors=True)
        cls.addClassCleanup(profile.cleanup)
        options = Options()
        options.binary_location = shutil.which("chromium")
        for word in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-first-run",
                     "--disable-background-networking", "--disable-component-update",
                     f"--user-data-dir={profile.name}"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", cls.LOGS)
        cls.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        cls.addClassCleanup(cls.driver.quit)
        cls.driver.set_page_load_timeout(PATIENCE)
        cls.driver.set_script_timeout(PATIENCE)

    def setUp(self):
        super().setUp()
        first = self.driver.current_window_handle
        self.driver.switch_to.new_window("tab")
        self.driver.get_log("browser")  # those of the test before
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": self.WIDTH, "height": self.HEIGHT, "deviceScaleFactor": self.SCALE, "mobile": False})

        def close():
            self.driver.close()
            self.driver.switch_to.window(first)

        self.addCleanup(close)

    def wait_until(self, condition, what):
        try:
            WebDriverWait(self.driver, PATIENCE, 0.3).until(lambda _: condition())
        except Exception as error:
            raise AssertionError(f"{what} did not come: {self.driver.get_log('browser')}") from error

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def finds(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def button(self, text):
        return self.driver.find_element(By.XPATH, f"//button[normalize-space()='{text}']")

    def run_script(self, script, *values):
        return self.driver.execute_script(script, *values)

    def errors(self):
        return [entry for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "ERROR")]
