// SPDX-License-Identifier: Apache-2.0
/// @file file_bytes.h
/// The room `files` handles files regardless of their content: it reads them whole, hashes them, writes them
/// atomically, sets them aside while something else is written, and names them by frame. It uses the room `base` only.
///
/// This header handles the bytes of input files, the format that a name implies, and names in messages. Sizes are in
/// bytes.
///
/// Every function that opens a file may throw:
/// @throw MissingInputError  the file does not exist, is a directory, or may not be opened
/// @throw IoError            reading failed midway
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

namespace vdbtools {

/// Passes the content to @a use, piece by piece in order. A piece is valid only during the call, and none is empty.
/// Devices and pipes are read to their end.
void readPieces(const std::filesystem::path& path, const std::function<void(std::string_view piece)>& use);

/// Returns the whole content, held in memory.
/// @throw MemoryError  it does not fit
std::string readWholeFile(const std::filesystem::path& path);

/// Opens a binary stream for a file of which only a part is read. Unlike std::ifstream, it retries the opening when a
/// signal interrupts it.
/// @throw MissingInputError  the file does not exist, may not be opened, or is a directory
std::ifstream openToRead(const std::filesystem::path& path);

/// Replaces every control character of @a text with a question mark, so that a file's content cannot send control
/// sequences to the terminal.
std::string withoutControls(std::string text);

/// As withoutControls(), and shortened if the text is too long for a message. Neither the content of a file nor its
/// name can then break a message into lines.
std::string inOneLine(std::string_view text);

/// Converts the letters A to Z of @a text to lower case, independent of the locale.
std::string lowerCase(std::string_view text);

/// The format that a name implies: its extension in lower case, with the dot; empty if there is none.
std::string lowerExtension(const std::filesystem::path& path);

}  // namespace vdbtools
