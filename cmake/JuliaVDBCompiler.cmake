# SPDX-License-Identifier: Apache-2.0
# The oldest compilers that were tried (docs/platforms.md). Older ones lack parts of C++20 or of its library.
set(oldest_GNU 12)
set(oldest_Clang 14)
set(package_GNU "g++ of Debian 12")
set(package_Clang "clang of Debian 12")
set(oldest "${oldest_${CMAKE_CXX_COMPILER_ID}}")
if(oldest AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS oldest)
  message(FATAL_ERROR "${CMAKE_CXX_COMPILER} is ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}, and ${oldest} or later "
                      "is needed, such as ${package_${CMAKE_CXX_COMPILER_ID}}; -DCMAKE_CXX_COMPILER=FILE names another compiler")
elseif(NOT oldest)
  message(STATUS "The compiler ${CMAKE_CXX_COMPILER_ID} was not tried; GNU ${oldest_GNU} and Clang ${oldest_Clang} were, and "
                 "later ones")
endif()
