# SPDX-License-Identifier: Apache-2.0
# The target `docs` makes HTML of the public headers. A warning is an error.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  set(DOXYGEN_QUIET YES)
  set(DOXYGEN_GENERATE_LATEX NO)
  set(DOXYGEN_HAVE_DOT NO)
  # The first sentence of a comment is its summary.
  set(DOXYGEN_JAVADOC_AUTOBRIEF YES)
  # What a name says by itself, a parameter's included, has no comment.
  set(DOXYGEN_EXTRACT_ALL YES)
  set(DOXYGEN_WARN_IF_INCOMPLETE_DOC NO)
  set(DOXYGEN_BUILTIN_STL_SUPPORT YES)
  set(DOXYGEN_WARN_AS_ERROR FAIL_ON_WARNINGS)
  set(DOXYGEN_STRIP_FROM_PATH libjulia/include vdbtools/include)
  set(DOXYGEN_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/docs)
  doxygen_add_docs(docs libjulia/include vdbtools/include)
  # The target `site` makes the pages with search, and the reference of both languages beside them; see docs/make-site.
  set(site ${PROJECT_SOURCE_DIR}/docs/make-site ${PROJECT_BINARY_DIR}/site --cpp ${PROJECT_BINARY_DIR}/docs/html)
  if(TARGET juliavdb_python)
    list(APPEND site --python ${PROJECT_BINARY_DIR}/python/juliavdb/__init__.pyi)
  endif()
  add_custom_target(site COMMAND ${site} VERBATIM)
  add_dependencies(site docs)
  if(TARGET juliavdb_python)
    add_dependencies(site juliavdb_python)
  endif()
  if(JULIAVDB_TESTS)
    add_test(NAME docs COMMAND Doxygen::doxygen ${CMAKE_CURRENT_BINARY_DIR}/Doxyfile.docs
             WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  endif()
endif()
