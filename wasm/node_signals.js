// SPDX-License-Identifier: Apache-2.0
// Ctrl-C and the like in Node: the program removes what it has not finished, and ends (cli/interruption.cpp).
if (!ENVIRONMENT_IS_PTHREAD) for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.on(signal, () => Module["_juliavdb_interrupt"]?.());
