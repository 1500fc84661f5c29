"""A browser without a window, for tests of pages."""

import base64
import json
import os
import shutil
import subprocess
import time

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")


class Browser:
    """A browser without a window, asked over a pipe by Chromium's own protocol."""

    def __init__(self, folder, address):
        """Open an address."""
        to, back = os.pipe(), os.pipe()
        options = "--headless=new --no-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader"
        command = (
            f"exec {CHROMIUM} {options} --user-data-dir={folder} --remote-debugging-pipe about:blank "
            f"3<&{to[0]} 4>&{back[1]}"
        )
        self._process = subprocess.Popen(
            ["bash", "-c", command], pass_fds=(to[0], back[1]), stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(to[0])
        os.close(back[1])
        self._to, self._back, self._rest = to[1], back[0], b""
        self._number, self._session = 0, {}
        target = self.ask("Target.createTarget", url=address)["targetId"]
        session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self._session = {"sessionId": session}

    def ask(self, method, **parameters):
        """Return what the browser answers to a method of its protocol."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters, **self._session}
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self._rest:
                part = os.read(self._back, 1 << 16)
                assert part, "the browser has ended"
                self._rest += part
            one, self._rest = self._rest.split(b"\0", 1)
            answer = json.loads(one)
            if answer.get("id") == self._number:
                return answer["result"]

    def value(self, expression):
        """Return the value of an expression of the page, None where there is none."""
        return self.ask("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def until(self, expression, wanted):
        """Wait until an expression has a value: against hanging alone, for minutes."""
        for _ in range(1200):
            if self.value(expression) == wanted:
                return
            time.sleep(0.1)
        raise AssertionError(f"{expression}: {self.value(expression)}, not {wanted}")

    def picture(self):
        """Return a PNG of what is seen."""
        return base64.b64decode(self.ask("Page.captureScreenshot")["data"])

    def end(self):
        """End it."""
        self._process.kill()
        self._process.wait()
        os.close(self._to)
        os.close(self._back)
