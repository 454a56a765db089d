// SPDX-License-Identifier: Apache-2.0
/// @file python_words.h
/// Converts the library's messages, which name options as the command line does, to the names of Python.
#pragma once

#include <string>
#include <string_view>

/// Replaces --sdf-resolution by sdf_resolution, for each option that Python has, too, and for the one with which a
/// message begins. Quoted text, such as a given value, stays unchanged.
std::string inPythonsWords(std::string_view message);
