// SPDX-License-Identifier: Apache-2.0
// Emscripten 3.1.69 fails where it is asked about a terminal on Node's own files; nothing is one.
addToLibrary({
  __syscall_ioctl: (fd, op, varargs) => -25,  // ENOTTY
});
