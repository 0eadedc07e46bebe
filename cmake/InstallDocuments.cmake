# SPDX-License-Identifier: Apache-2.0
# Run by `cmake --install`: README.md and docs/, whose links to headers and to shipped data lead to the installed ones.
# KnuckleInstall.cmake sets source_folder and, below the prefix, document_folder, data_folder and include_folder.
file(GLOB documents RELATIVE ${source_folder} ${source_folder}/*.md ${source_folder}/docs/*.md)
foreach(document IN LISTS documents)
  cmake_path(GET document PARENT_PATH folder)
  set(target_folder ${document_folder}/${folder})
  file(RELATIVE_PATH data /${target_folder} /${data_folder})
  file(RELATIVE_PATH headers /${target_folder} /${include_folder}/knuckle)
  file(READ ${source_folder}/${document} text)
  string(REGEX REPLACE "\\]\\((\\.\\./)*(landmarks|manifests|models|pipelines|experiments|schemas)/" "](${data}/\\2/" text "${text}")
  string(REGEX REPLACE "\\]\\((\\.\\./)*src/knuckle/" "](${headers}/" text "${text}")
  set(installed ${CMAKE_INSTALL_PREFIX}/${document_folder}/${document})
  message(STATUS "Installing: $ENV{DESTDIR}${installed}")
  file(WRITE $ENV{DESTDIR}${installed} "${text}")
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES ${installed})
endforeach()
