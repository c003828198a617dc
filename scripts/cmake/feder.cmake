# One set of compile flags, and the words that add things:
#   feder_module(name [APART] SOURCES a.cpp ... NEEDS base ...)   a static library feder_<name>; APART: see pch.cmake
#   feder_variant(module name [FILE file.cpp] [TABLE table])      one source and one row of the module's table, or of
#                                                                 another one that feder_module(... TABLES table) has
#   feder_pair(a b)                                               the same for a narrow-phase pair test
#   feder_system(module Class header)                             a row of the catalog and of the built feder/systems.h
# A variant is a function `Row <module>_<name>();` in namespace feder; the module's registry.cpp includes the
# generated <module>_declare.inc (declarations) and <module>_rows.inc (rows, in the order of the lines); those of another
# table are RowOf<table>, in <module>_<table>_declare.inc and <module>_<table>_rows.inc.

include(${CMAKE_CURRENT_LIST_DIR}/pch.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/without.cmake)
find_program(FEDER_CCACHE ccache)
if(FEDER_CCACHE AND NOT FEDER_PCH AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${FEDER_CCACHE})
endif()

set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
set(CMAKE_CXX_FLAGS_DEV "-O1 -g")

option(FEDER_WERROR "as continuous integration builds: warnings of gcc are errors, debuggers see lines alone" OFF)
if(FEDER_SANITIZE OR FEDER_WERROR)
  set(CMAKE_CXX_FLAGS_DEV "-O1 -g1")  # enough for reports; the rest is a fifth of compiling, and links for minutes
endif()

# feder_silent(target...): headers of a library that is built along, as find_package would give them
function(feder_silent)
  foreach(target ${ARGN})
    get_target_property(aliased ${target} ALIASED_TARGET)
    if(aliased)
      set(target ${aliased})
    endif()
    get_target_property(headers ${target} INTERFACE_INCLUDE_DIRECTORIES)
    set_property(TARGET ${target} PROPERTY INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${headers})
  endforeach()
endfunction()

find_package(Eigen3 3.4 QUIET NO_MODULE)
if(NOT TARGET Eigen3::Eigen)
  include(FetchContent)
  FetchContent_Declare(eigen URL https://gitlab.com/libeigen/eigen/-/archive/3.4.0/eigen-3.4.0.tar.gz)
  set(EIGEN_BUILD_DOC OFF)
  set(BUILD_TESTING OFF)
  FetchContent_MakeAvailable(eigen)
  if(NOT TARGET Eigen3::Eigen)
    add_library(Eigen3::Eigen ALIAS eigen)
  endif()
  feder_silent(Eigen3::Eigen)
endif()
find_package(Threads REQUIRED)

# Same result for every compiler and optimisation level: no contraction, no fast-math, errno-free sqrt.
add_library(feder_flags INTERFACE)
add_library(feder::flags ALIAS feder_flags)
target_compile_features(feder_flags INTERFACE cxx_std_20)
target_compile_options(feder_flags INTERFACE
  $<BUILD_INTERFACE:-Wno-psabi;-fno-math-errno;-fno-trapping-math> -ffp-contract=off)
# Warnings are for those who build feder itself, and errors in continuous integration only: a newer compiler knows more.
# clang counts signs as conversions, which is no use here. gcc 12 warns of std::string + const char* (its bug 105651);
# what depends on inlining it finds within its own headers too, so that stays a warning.
if(PROJECT_IS_TOP_LEVEL)
  target_compile_options(feder_flags INTERFACE $<BUILD_INTERFACE:-Wall;-Wextra>)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(feder_flags INTERFACE
      $<BUILD_INTERFACE:-Wshadow;-Wconversion;-Wold-style-cast;-Wno-restrict;-Wno-subobject-linkage>)  # the last: sources in lumps
    if(FEDER_WERROR)
      target_compile_options(feder_flags INTERFACE
        $<BUILD_INTERFACE:-Werror;-Wno-error=maybe-uninitialized;-Wno-error=array-bounds;-Wno-error=stringop-overflow>)
    endif()
  endif()
endif()
if(FEDER_REAL STREQUAL "double")
  target_compile_definitions(feder_flags INTERFACE FEDER_REAL_DOUBLE=1)
elseif(NOT FEDER_REAL STREQUAL "float")
  message(FATAL_ERROR "FEDER_REAL is float or double, not '${FEDER_REAL}'")
endif()
if(FEDER_SANITIZE)
  target_compile_options(feder_flags INTERFACE -fsanitize=${FEDER_SANITIZE} -fno-sanitize-recover=all
                         -fno-omit-frame-pointer)
  if(FEDER_SANITIZE_NOT)
    target_compile_options(feder_flags INTERFACE -fno-sanitize=${FEDER_SANITIZE_NOT})
  endif()
  target_link_options(feder_flags INTERFACE -fsanitize=${FEDER_SANITIZE})
  target_compile_definitions(feder_flags INTERFACE FEDER_SANITIZED=1)
endif()
target_link_libraries(feder_flags INTERFACE Eigen3::Eigen Threads::Threads)

set_property(GLOBAL PROPERTY FEDER_MODULES "")

function(feder_left_out out name)
  list(FIND FEDER_WITHOUT "${name}" at)
  if(at GREATER -1)
    set(${out} TRUE PARENT_SCOPE)
  else()
    set(${out} FALSE PARENT_SCOPE)
  endif()
endfunction()

function(feder_module name)
  cmake_parse_arguments(M "APART" "ROOT" "SOURCES;NEEDS;TABLES" ${ARGN})
  feder_known(${name})
  feder_left_out(left_out ${name})
  if(left_out)
    return()
  endif()
  set(M_ROOT ${PROJECT_SOURCE_DIR}/runtime ${M_ROOT})
  set(target feder_${name})
  add_library(${target} STATIC ${M_SOURCES})
  add_library(feder::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} LINKER_LANGUAGE CXX CXX_VISIBILITY_PRESET hidden
                        VISIBILITY_INLINES_HIDDEN ON)
  # a host sees feder/*.h alone
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/runtime/include> $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/generated>
    $<INSTALL_INTERFACE:include>)
  target_include_directories(${target} PRIVATE ${M_ROOT} ${CMAKE_CURRENT_BINARY_DIR})
  target_link_libraries(${target} PUBLIC feder_flags)
  feder_use_pch(${target} library)
  if(NOT M_APART)
    feder_in_lumps(${target})
  endif()
  foreach(need ${M_NEEDS})
    target_link_libraries(${target} PUBLIC feder_${need})
  endforeach()
  set_property(GLOBAL APPEND PROPERTY FEDER_MODULES ${name})
  set_property(GLOBAL PROPERTY FEDER_NEEDS_${name} ${M_NEEDS})
  set_property(GLOBAL PROPERTY FEDER_DECLARE_${name} "")
  set_property(GLOBAL PROPERTY FEDER_ROWS_${name} "")
  foreach(table "" ${M_TABLES})
    set(file ${CMAKE_CURRENT_BINARY_DIR}/${name})
    if(table)
      set(file ${file}_${table})
    endif()
    file(GENERATE OUTPUT ${file}_declare.inc CONTENT "$<JOIN:$<TARGET_PROPERTY:${target},FEDER_DECLARE${table}>,\n>\n")
    file(GENERATE OUTPUT ${file}_rows.inc CONTENT "$<JOIN:$<TARGET_PROPERTY:${target},FEDER_ROWS${table}>,\n>\n")
  endforeach()
endfunction()

function(feder_variant module name)
  cmake_parse_arguments(V "" "FILE;TABLE" "ALSO" ${ARGN})
  feder_known(${module}.${name})
  feder_left_out(module_out ${module})
  feder_left_out(variant_out ${module}.${name})
  if(module_out OR variant_out)
    return()
  endif()
  if(NOT V_FILE)
    set(V_FILE ${name}.cpp)
  endif()
  set(row Row)
  if(V_TABLE)
    set(row RowOf${V_TABLE})
  endif()
  foreach(file ${V_FILE} ${V_ALSO})
    target_sources(feder_${module} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  endforeach()
  set_property(TARGET feder_${module} APPEND PROPERTY FEDER_DECLARE${V_TABLE} "${row} ${module}_${name}()\;")
  set_property(TARGET feder_${module} APPEND PROPERTY FEDER_ROWS${V_TABLE} "${module}_${name}(),")
endfunction()

function(feder_system module class header)
  if(TARGET feder_${module})
    string(REGEX REPLACE "([a-z])([A-Z])" "\\1_\\2" name ${class})
    string(TOLOWER ${name}_system name)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
    file(CONFIGURE OUTPUT ${source} @ONLY CONTENT "#include \"@header@\"

namespace feder {
const SystemDescriptor& @name@() { return @class@::descriptor(); }
}  // namespace feder
")
    target_sources(feder_${module} PRIVATE ${source})
    set_property(GLOBAL APPEND PROPERTY FEDER_SYSTEM_MODULES ${module})
    set_property(GLOBAL APPEND PROPERTY FEDER_SYSTEM_NAMES ${name})
  endif()
endfunction()

function(feder_pair a b)
  feder_variant(narrow ${a}_${b})
endfunction()
