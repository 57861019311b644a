# cmake --install: headers under include/pathfit, static libraries, the program, and what find_package(pathfit) reads.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
include(${CMAKE_CURRENT_LIST_DIR}/public_headers.cmake)

# Sources include each other from the root of the repository; installed headers from include/.
install(CODE "
  foreach(header ${PATHFIT_PUBLIC_HEADERS})
    file(READ \"${PROJECT_SOURCE_DIR}/\${header}\" text)
    string(REGEX REPLACE \"#include \\\"(renderer|optim)/\" \"#include \\\"pathfit/\\\\1/\" text \"\${text}\")
    set(target \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/pathfit/\${header}\")
    message(STATUS \"Installing: \${target}\")
    file(WRITE \"\$ENV{DESTDIR}\${target}\" \"\${text}\")
  endforeach()" COMPONENT dev)

set_target_properties(pathfit_renderer PROPERTIES EXPORT_NAME renderer)
set_target_properties(pathfit_optim PROPERTIES EXPORT_NAME optim)
set_target_properties(pathfit_flags PROPERTIES EXPORT_NAME flags)
set_target_properties(pathfit_opencv PROPERTIES EXPORT_NAME opencv)
install(TARGETS pathfit_renderer pathfit_optim pathfit_flags pathfit_opencv EXPORT pathfitTargets
  ARCHIVE COMPONENT dev INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS pathfit COMPONENT program)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/pathfit)
install(EXPORT pathfitTargets NAMESPACE pathfit:: DESTINATION ${package_folder} COMPONENT dev)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/pathfitConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/pathfitConfig.cmake ${PROJECT_BINARY_DIR}/pathfitConfigVersion.cmake
  DESTINATION ${package_folder} COMPONENT dev)

# Man page and completions, from the program's own declarations.
foreach(script IN ITEMS man:pathfit.1 bash:pathfit zsh:_pathfit fish:pathfit.fish)
  string(REPLACE ":" ";" script ${script})
  list(GET script 0 kind)
  list(GET script 1 name)
  set(file ${PROJECT_BINARY_DIR}/${kind}/${name})
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/${kind})
  add_custom_command(OUTPUT ${file} COMMAND pathfit completion ${kind} > ${file} DEPENDS pathfit VERBATIM)
  list(APPEND command_line_files ${file})
endforeach()
add_custom_target(command_line_files ALL DEPENDS ${command_line_files})
install(FILES ${PROJECT_BINARY_DIR}/man/pathfit.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1
  COMPONENT program)
install(FILES ${PROJECT_BINARY_DIR}/bash/pathfit DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
  COMPONENT program)
install(FILES ${PROJECT_BINARY_DIR}/zsh/_pathfit DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions
  COMPONENT program)
install(FILES ${PROJECT_BINARY_DIR}/fish/pathfit.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d
  COMPONENT program)

if(PATHFIT_PYTHON)
  if(SKBUILD)
    set(python_folder .)  # pip's own place
  else()
    set(python_folder ${CMAKE_INSTALL_LIBDIR}/python3/dist-packages)  # where Debian's interpreter looks below /usr
  endif()
  install(TARGETS pathfit_python LIBRARY DESTINATION ${python_folder} COMPONENT python)
  install(FILES ${PROJECT_SOURCE_DIR}/app/python/pathfit.pyi DESTINATION ${python_folder} COMPONENT python)
endif()
