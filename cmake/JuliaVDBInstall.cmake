# SPDX-License-Identifier: Apache-2.0
# find_package(JuliaVDB) provides juliavdb::julia and juliavdb::vdbtools.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/JuliaVDB)
configure_package_config_file(cmake/JuliaVDBConfig.cmake.in ${PROJECT_BINARY_DIR}/JuliaVDBConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/JuliaVDBConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/JuliaVDBConfig.cmake ${PROJECT_BINARY_DIR}/JuliaVDBConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/JuliaVDBDependencies.cmake
        DESTINATION ${package_dir})
install(TARGETS julia vdbtools juliavdb_cli juliavdb_flags juliavdb_warnings EXPORT JuliaVDBTargets
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET vdbtools_images)
  install(TARGETS vdbtools_images LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()
install(EXPORT JuliaVDBTargets NAMESPACE juliavdb:: DESTINATION ${package_dir})
install(DIRECTORY libjulia/include/julia vdbtools/include/vdbtools DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
