// SPDX-License-Identifier: Apache-2.0
/// @file mesh_comments.h
/// The recipe as comments at the beginning of a text: lines "START juliavdb KEY VALUE".
#pragma once

#include "vdbtools/files/file_format.h"

#include <iosfwd>
#include <string>

namespace vdbtools {

/// @param start  what a comment of the format begins with
std::string commentLines(const std::string& start, const FileTexts& texts);

/// Reads the comments from the file's beginning, up to the first line that is not a comment of this project. The state
/// of the stream shows read errors.
FileTexts readCommentLines(std::istream& stream, const std::string& start);

}  // namespace vdbtools
