# SPDX-License-Identifier: Apache-2.0
# `cmake --install` and CPack: the program, headers, libraries, models and pipelines, and a CMake package `knuckle`.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME knuckle)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/knuckle)
set(data_folder ${CMAKE_INSTALL_DATADIR}/knuckle)

install(TARGETS knuckle_runtime knuckle_library EXPORT knuckleTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS knuckle RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS knuckle-train-network RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT training)
install(DIRECTORY src/knuckle DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h"
        PATTERN "*testing*" EXCLUDE PATTERN "*fixtures*" EXCLUDE PATTERN "cli" EXCLUDE PATTERN "training" EXCLUDE)
install(DIRECTORY experiments models pipelines manifests DESTINATION ${data_folder})
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(EXPORT knuckleTargets NAMESPACE knuckle:: DESTINATION ${package_folder})
configure_package_config_file(cmake/knuckleConfig.cmake.in knuckleConfig.cmake INSTALL_DESTINATION ${package_folder}
                              PATH_VARS data_folder)
write_basic_package_version_file(knuckleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/knuckleConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/knuckleConfigVersion.cmake
              cmake/KnuckleDependencies.cmake DESTINATION ${package_folder})

set(CPACK_PACKAGE_CONTACT "The Knuckle developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_KNUCKLE_PACKAGE_RECOMMENDS gnuplot-nox)
# Only who trains networks needs LibTorch: a package of its own.
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL knuckle training)
set(CPACK_DEBIAN_KNUCKLE_PACKAGE_NAME knuckle)
set(CPACK_DEBIAN_KNUCKLE_PACKAGE_SUGGESTS knuckle-training)
set(CPACK_DEBIAN_TRAINING_PACKAGE_NAME knuckle-training)
set(CPACK_DEBIAN_TRAINING_PACKAGE_DEPENDS "knuckle (= ${PROJECT_VERSION})")
set(CPACK_STRIP_FILES ON)
include(CPack)
