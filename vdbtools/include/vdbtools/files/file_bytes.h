// SPDX-License-Identifier: Apache-2.0
/// @file file_bytes.h
/// The room `files` handles files whatever they hold: read whole, hashed, written atomically, put aside while something
/// else is written, named by frame. It uses the room `base` only.
///
/// Here: the bytes of input files, the format that a name stands for, and names in messages. Sizes are in bytes.
///
/// Every function that opens a file
/// @throw MissingInputError  there is no such file, it is a directory, or it may not be opened
/// @throw IoError            reading broke off
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

namespace vdbtools {

/// Gives the content to @a use, piece after piece in order. A piece lives only as long as the call, and none is empty.
/// Devices and pipes are read to their end.
void readPieces(const std::filesystem::path& path, const std::function<void(std::string_view piece)>& use);

/// The whole content, held in memory.
/// @throw MemoryError  it does not fit
std::string readWholeFile(const std::filesystem::path& path);

/// A binary stream, for a file of which only a part is read. Unlike that of std::ifstream, its opening begins again
/// when a signal interrupts it.
/// @throw MissingInputError  there is no such file, it may not be opened, or it is a directory
std::ifstream openToRead(const std::filesystem::path& path);

/// @a text with a question mark for every control character: what a file holds cannot speak to the terminal that shows
/// it.
std::string withoutControls(std::string text);

/// The same, cut where it is too long for a message: neither the content of a file nor its name can break a message
/// into lines.
std::string inOneLine(std::string_view text);

/// @a text with the letters A to Z in lower case, whatever the locale.
std::string lowerCase(std::string_view text);

/// The format that a name stands for: its extension in lower case, with the dot; empty if there is none.
std::string lowerExtension(const std::filesystem::path& path);

}  // namespace vdbtools
