# SPDX-License-Identifier: Apache-2.0
"""A host of static files, for the tests of pages that have no server of ours."""

import functools
import http.server
import sys
import threading

# What isolates a page from others, so that it has threads.
ISOLATED = {"Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Embedder-Policy": "require-corp"}


class StaticHost(http.server.ThreadingHTTPServer):
    """Serves a folder until close(). asked: all requests so far, as (method, path).

    @param headers  what every answer has besides the usual headers
    @param handler  what answers, if other addresses than those of files do"""

    def __init__(self, folder, headers=None, handler=http.server.SimpleHTTPRequestHandler):
        self.asked = asked = []

        class Handler(handler):
            def end_headers(self):
                for name, value in (headers or {}).items():
                    self.send_header(name, value)
                super().end_headers()

            def log_request(self, *unused):
                asked.append((self.command, self.path))

            def log_message(self, *unused):
                pass

        super().__init__(("127.0.0.1", 0), functools.partial(Handler, directory=folder))
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def handle_error(self, *unused):
        if not isinstance(sys.exc_info()[1], ConnectionError):  # a page that is left hears no answers any more
            super().handle_error(*unused)

    @property
    def url(self):
        return f"http://localhost:{self.server_address[1]}/"

    def close(self):
        self.shutdown()
        self.server_close()
