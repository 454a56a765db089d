// SPDX-License-Identifier: Apache-2.0
// What the program asks of Node's process. Ctrl-C and the like: it removes what it has not finished, and ends
// (cli/interruption.cpp). Terminals: Emscripten 3.1.69 takes every standard stream for one, and progress would be drawn into files.
if (!ENVIRONMENT_IS_PTHREAD) {
  for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.on(signal, () => Module["_juliavdb_interrupt"]?.());
  Module["onRuntimeInitialized"] = () => {
    for (const number of [0, 1, 2]) FS.getStream(number).tty = require("tty").isatty(number);
  };
}
