# cmake --install: the library for other projects, found by find_package(meanvalue) as meanvalue::meanvalue.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/meanvalue)

install(TARGETS meanvalue_core EXPORT meanvalue_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT meanvalue_targets NAMESPACE meanvalue:: FILE meanvalueTargets.cmake DESTINATION ${package_dir})
# The public headers, and what they include.
foreach(header
    meanvalue.h
    common/errors.h common/execution.h deform/deformer.h morph/morpher.h sequence/sequence.h sliders/slider_fit.h
    common/instruction_set.h common/physical_memory.h common/shared_arrays.h common/types.h deform/binding.h mesh/component.h)
  get_filename_component(folder ${header} DIRECTORY)
  install(FILES ${CMAKE_CURRENT_SOURCE_DIR}/meanvalue/${header}
    DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meanvalue/${folder})
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})

file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfig.cmake
"include(CMakeFindDependencyMacro)
find_dependency(Eigen3 CONFIG)
find_dependency(OpenMesh CONFIG)
find_dependency(Threads)
include(\${CMAKE_CURRENT_LIST_DIR}/meanvalueTargets.cmake)
")
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
  ${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfig.cmake
  ${CMAKE_CURRENT_BINARY_DIR}/meanvalueConfigVersion.cmake
  DESTINATION ${package_dir})
