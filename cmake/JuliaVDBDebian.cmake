# SPDX-License-Identifier: Apache-2.0
# CPack runs this over the files of the Debian package. Debian's policy wants manual pages and changelogs compressed, and
# a changelog in its own form, which refers to ours.
file(GLOB roots ${CPACK_TEMPORARY_DIRECTORY}/*/usr/share)
foreach(share ${roots})
  file(STRINGS ${share}/doc/juliavdb/CHANGELOG.md heading REGEX "^## ${CPACK_PACKAGE_VERSION} \\(")
  string(REGEX MATCH "[0-9]+-[0-9]+-[0-9]+" day "${heading}")
  execute_process(COMMAND date -u -R -d "${day}" OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE ${share}/doc/juliavdb/changelog
       "juliavdb (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium\n\n  * CHANGELOG.md says what is new.\n\n"
       " -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${date}\n")
  file(GLOB texts ${share}/man/man1/*.1)
  execute_process(COMMAND gzip -9 -n -f ${texts} ${share}/doc/juliavdb/changelog COMMAND_ERROR_IS_FATAL ANY)
endforeach()
