// SPDX-License-Identifier: Apache-2.0
/// @file loop_pragmas.h
/// What a compiler is told of the loop that follows. It changes the speed and no bit of a result.
///
/// Only g++ is told, and only where it optimises. Clang sees most of it by itself, and warns of what it cannot do.
#pragma once

#if defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__)
/// The passes through the loop are independent of each other.
#define JULIA_INDEPENDENT _Pragma("GCC ivdep")
/// The loop is short: its body is repeated in place.
#define JULIA_UNROLLED_4 _Pragma("GCC unroll 4")
#define JULIA_UNROLLED_32 _Pragma("GCC unroll 32")
#else
#define JULIA_INDEPENDENT
#define JULIA_UNROLLED_4
#define JULIA_UNROLLED_32
#endif
