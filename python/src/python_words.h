// SPDX-License-Identifier: Apache-2.0
/// @file python_words.h
/// The library names options as the command line does. Here its messages are put into the words of Python.
#pragma once

#include <string>
#include <string_view>

/// --sdf-resolution becomes sdf_resolution, for every option that Python has, too, and for the one that a message
/// begins with. What stands in quotes, such as the value that was given, stays as it is.
std::string inPythonsWords(std::string_view message);
