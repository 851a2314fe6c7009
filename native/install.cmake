# cmake --install: the library for other projects, found by find_package(meanvalue) as meanvalue::meanvalue.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/meanvalue)

install(TARGETS meanvalue_core EXPORT meanvalue_targets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(EXPORT meanvalue_targets NAMESPACE meanvalue:: FILE meanvalueTargets.cmake DESTINATION ${package_dir})
install(DIRECTORY include/meanvalue DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(FILES LICENSE ${PROJECT_SOURCE_DIR}/NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})

# A shared library has taken what it needs, and so has OpenMesh that was compiled along.
set(also "")
if(NOT BUILD_SHARED_LIBS)
  string(APPEND also "find_dependency(Threads)\n")
  if(NOT MEANVALUE_OPENMESH_SOURCE)
    string(APPEND also "find_dependency(OpenMesh CONFIG)\n")
  endif()
endif()
file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfig.cmake
"include(CMakeFindDependencyMacro)
find_dependency(Eigen3 CONFIG)
${also}include(\${CMAKE_CURRENT_LIST_DIR}/meanvalueTargets.cmake)
")
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfigVersion.cmake
  DESTINATION ${package_dir})
