// SPDX-License-Identifier: Apache-2.0
/// @file embedded_page.h
/// The room `explore` holds what `juliavdb explore` needs: a page in the browser that shows the set live, the data from
/// which it does so, and a server on this machine that makes pictures and files for it. It may use all other rooms.
///
/// Here: the files of the page, which are compiled into the library. They are those of vdbtools/src/explore/page.
#pragma once

#include <span>
#include <string_view>

namespace vdbtools::explore {

struct PageFile {
  std::string_view name;         ///< of the file, without a folder
  std::string_view bytes;        ///< all of them
  std::string_view contentType;  ///< as HTTP has it, such as "text/css; charset=utf-8"
};

/// All files, in the order of their names.
std::span<const PageFile> embeddedPage();

/// nullptr: there is none of that name.
const PageFile* findPageFile(std::string_view name);

}  // namespace vdbtools::explore
