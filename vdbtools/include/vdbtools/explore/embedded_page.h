// SPDX-License-Identifier: Apache-2.0
/// @file embedded_page.h
/// The room `explore` holds what `juliavdb explore` needs: a page in the browser that shows the set live, the data from
/// which it does so, and a server on this machine that makes pictures and files for it. It may use all other rooms.
///
/// This header declares the files of the page, which are compiled into the library from vdbtools/src/explore/page.
#pragma once

#include <span>
#include <string_view>

namespace vdbtools::explore {

struct PageFile {
  std::string_view name;         ///< the file name, without a folder
  std::string_view bytes;        ///< the content
  std::string_view contentType;  ///< its HTTP content type, such as "text/css; charset=utf-8"
};

/// All files, in the order of their names.
std::span<const PageFile> embeddedPage();

/// Returns nullptr if there is no file of that name.
const PageFile* findPageFile(std::string_view name);

}  // namespace vdbtools::explore
