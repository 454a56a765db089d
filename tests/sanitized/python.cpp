// SPDX-License-Identifier: Apache-2.0
/// @file python.cpp
/// Python with a sanitizer's runtime, without which it cannot load a module that is instrumented.
#include <Python.h>

/// Python keeps much until it ends, in pools that LeakSanitizer does not search.
extern "C" __attribute__((visibility("default"))) int __lsan_is_turned_off() { return 1; }

int main(int argc, char** argv) { return Py_BytesMain(argc, argv); }
