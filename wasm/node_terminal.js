// SPDX-License-Identifier: Apache-2.0
// Emscripten 3.1.69 fails where a terminal is asked about its size or its modes; none has any (node_process.js says which are terminals).
addToLibrary({
  __syscall_ioctl: (fd, op, varargs) => -25,  // ENOTTY
});
