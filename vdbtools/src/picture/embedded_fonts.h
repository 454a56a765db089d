// SPDX-License-Identifier: Apache-2.0
/// @file embedded_fonts.h
/// The files of DejaVu Sans, embedded in the library, so that text looks the same whatever fonts a machine has.
#pragma once

#include <cstddef>
#include <span>

namespace vdbtools {

/// A TrueType file.
std::span<const unsigned char> embeddedFont(bool isBold);

}  // namespace vdbtools
