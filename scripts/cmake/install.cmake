# install() and the exported package. find_package(feder) gives
#   feder::feder   the whole runtime;  feder::<module> each of its modules (a host links what its scenes use)
#   feder::study   problems, error against run time, stability maps (feder/study.h)
#   feder::lua     the Lua binding (feder/lua.h), when it was built; feder::lua_core and feder::lua_<module> for a host that
#                  names the parts it wants (feder/parts.h)
#   feder::yaml    YAML scenes, with find_package(feder COMPONENTS yaml)
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(FEDER_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/feder)
get_property(feder_modules GLOBAL PROPERTY FEDER_MODULES)
list(REMOVE_ITEM feder_modules report cli view live states window reference)  # parts of the program, not of the library

add_library(feder_all INTERFACE)
add_library(feder::feder ALIAS feder_all)
set_target_properties(feder_all PROPERTIES EXPORT_NAME feder)
set_target_properties(feder_flags PROPERTIES EXPORT_NAME flags)
set(feder_exported feder_all feder_flags)
set(FEDER_HAS_LUA OFF)
set(FEDER_HAS_YAML OFF)
foreach(module ${feder_modules})
  if(module STREQUAL "yaml")
    set(FEDER_HAS_YAML ON)
    continue()
  endif()
  list(APPEND feder_exported feder_${module})
  if(module MATCHES "^lua")  # feder::lua with all its parts, feder::lua_core with those that a host names
    set(FEDER_HAS_LUA ON)
  elseif(NOT module STREQUAL "study")
    target_link_libraries(feder_all INTERFACE feder_${module})
  endif()
endforeach()

install(TARGETS ${feder_exported} EXPORT feder_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/feder)
install(EXPORT feder_targets NAMESPACE feder:: DESTINATION ${FEDER_PACKAGE_DIR})
set(feder_headers PATTERN "*.h")
foreach(header lua yaml)
  string(TOUPPER ${header} name)
  if(NOT FEDER_HAS_${name})
    list(APPEND feder_headers PATTERN "${header}.h" EXCLUDE)
  endif()
endforeach()
install(DIRECTORY runtime/include/feder ${PROJECT_BINARY_DIR}/generated/feder DESTINATION include FILES_MATCHING ${feder_headers})
if(FEDER_HAS_YAML)
  install(TARGETS feder_yaml EXPORT feder_yaml_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/feder)
  install(EXPORT feder_yaml_targets NAMESPACE feder:: DESTINATION ${FEDER_PACKAGE_DIR})
endif()
if(TARGET feder)
  install(TARGETS feder RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
# what `require` finds (the program looks beside itself for ../share/feder/scripts) and the example scenes
install(DIRECTORY scripts/feder DESTINATION ${CMAKE_INSTALL_DATADIR}/feder/scripts FILES_MATCHING PATTERN "*.lua")
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/feder)

configure_package_config_file(scripts/cmake/feder-config.cmake.in ${PROJECT_BINARY_DIR}/feder-config.cmake
                              INSTALL_DESTINATION ${FEDER_PACKAGE_DIR})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/feder-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/feder-config.cmake ${PROJECT_BINARY_DIR}/feder-config-version.cmake
        DESTINATION ${FEDER_PACKAGE_DIR})
