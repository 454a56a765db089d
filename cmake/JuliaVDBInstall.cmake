# SPDX-License-Identifier: Apache-2.0
# find_package(JuliaVDB) provides juliavdb::julia and juliavdb::vdbtools; and vdbtools::fit, vdbtools::farm and
# vdbtools::explore, which are built on them.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/JuliaVDB)
# Who links to shared libraries compiles against their headers only.
if(BUILD_SHARED_LIBS)
  set(JULIAVDB_CONSUMER_DEPENDENCIES JuliaVDBPublicDependencies)
else()
  set(JULIAVDB_CONSUMER_DEPENDENCIES JuliaVDBDependencies)
endif()
configure_package_config_file(cmake/JuliaVDBConfig.cmake.in ${PROJECT_BINARY_DIR}/JuliaVDBConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/JuliaVDBConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/JuliaVDBConfig.cmake ${PROJECT_BINARY_DIR}/JuliaVDBConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/JuliaVDBDependency.cmake
              ${PROJECT_SOURCE_DIR}/cmake/JuliaVDBPublicDependencies.cmake
              ${PROJECT_SOURCE_DIR}/cmake/JuliaVDBDependencies.cmake
        DESTINATION ${package_dir} COMPONENT Development)
install(TARGETS julia vdbtools juliavdb_cli juliavdb_flags juliavdb_warnings juliavdb_light EXPORT JuliaVDBTargets
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT Runtime
        ARCHIVE DESTINATION ${JULIAVDB_LIBDIR} COMPONENT Development
        LIBRARY DESTINATION ${JULIAVDB_LIBDIR} COMPONENT Runtime)
if(TARGET vdbtools_images)
  install(TARGETS vdbtools_images LIBRARY DESTINATION ${JULIAVDB_LIBDIR} COMPONENT Runtime)
endif()
install(TARGETS vdbtools_fit vdbtools_farm vdbtools_explore EXPORT VdbtoolsTargets
        ARCHIVE DESTINATION ${JULIAVDB_LIBDIR} COMPONENT Development
        LIBRARY DESTINATION ${JULIAVDB_LIBDIR} COMPONENT Runtime)
install(EXPORT VdbtoolsTargets NAMESPACE vdbtools:: DESTINATION ${package_dir} COMPONENT Development)
install(EXPORT JuliaVDBTargets NAMESPACE juliavdb:: DESTINATION ${package_dir} COMPONENT Development)
install(DIRECTORY libjulia/include/julia vdbtools/include/vdbtools DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        COMPONENT Development)
