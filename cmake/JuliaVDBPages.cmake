# SPDX-License-Identifier: Apache-2.0
# Manual pages and the completion for shells: the program writes them from what its help says.
set(pages ${PROJECT_BINARY_DIR}/pages)
set(program $<TARGET_FILE:juliavdb_cli>)
if(JULIAVDB_SANITIZE MATCHES "thread")
  set(program ${CMAKE_COMMAND} -E env TSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tests/sanitized/races.supp ${program})
endif()
add_custom_command(
  OUTPUT ${pages}/juliavdb.bash
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${pages}
  COMMAND ${program} man -o ${pages}/man1 --progress none
  COMMAND ${program} completion > ${pages}/juliavdb.bash
  COMMAND ${program} completion zsh > ${pages}/_juliavdb
  COMMAND ${program} completion fish > ${pages}/juliavdb.fish
  DEPENDS juliavdb_cli
  COMMENT "Writing manual pages and the completion for shells"
  VERBATIM)
add_custom_target(juliavdb_pages ALL DEPENDS ${pages}/juliavdb.bash)

install(DIRECTORY ${pages}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT Runtime)
install(FILES ${pages}/juliavdb.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME juliavdb
        COMPONENT Runtime)
install(FILES ${pages}/_juliavdb DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT Runtime)
install(FILES ${pages}/juliavdb.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT Runtime)
