// SPDX-License-Identifier: Apache-2.0
/// @file loop_pragmas.h
/// Hints to the compiler about the following loop. They change the speed and no bit of a result.
///
/// They apply only to g++ when it optimises. Clang detects most of this by itself, and warns about hints that it cannot
/// follow.
#pragma once

#if defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__)
/// The passes through the loop are independent of each other.
#define JULIA_INDEPENDENT _Pragma("GCC ivdep")
/// The loop is short, so it is unrolled.
#define JULIA_UNROLLED_4 _Pragma("GCC unroll 4")
#define JULIA_UNROLLED_32 _Pragma("GCC unroll 32")
#else
#define JULIA_INDEPENDENT
#define JULIA_UNROLLED_4
#define JULIA_UNROLLED_32
#endif
