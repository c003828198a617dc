# Precompiled headers for first builds on machines without a compiler cache: reading Eigen and the standard library is
# half of compiling a file here. Off by default, because a cache (ccache) does more and does not work with them.
option(FEDER_PCH "precompiled headers instead of a compiler cache" OFF)

set(feder_pch_standard <algorithm> <array> <cmath> <cstdint> <cstring> <functional> <map> <memory> <optional> <string>
                       <string_view> <utility> <vector> <Eigen/Core>)

# what tests do themselves is little: optimising it is a third of compiling them
set(feder_test_flags $<$<CONFIG:Release,Check>:-O1>)

# feder_in_lumps(target): several sources per compilation, as half of what is left is the same templates again. Names in
# unnamed namespaces must then differ within the folder; modules of variants, which look alike on purpose, are APART,
# and so is each file with a table of rows, as all call their type Row.
function(feder_in_lumps target)
  if(FEDER_PCH AND TARGET ${target})
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 14)
    set_source_files_properties(registry.cpp panel_inspector.cpp picking.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# feder_use_pch(target library|test): after the target's sources; files with flags of their own are left out.
function(feder_use_pch target kind)
  if(NOT FEDER_PCH)
    return()
  endif()
  if(NOT TARGET feder_pch_${kind})
    file(GENERATE OUTPUT ${PROJECT_BINARY_DIR}/pch/${kind}.cpp CONTENT "int main() {}\n")
    if(kind STREQUAL "test")
      add_executable(feder_pch_test ${PROJECT_BINARY_DIR}/pch/test.cpp)
      target_link_libraries(feder_pch_test PRIVATE feder_flags Catch2::Catch2)
      target_precompile_headers(feder_pch_test PRIVATE ${feder_pch_standard} "${PROJECT_SOURCE_DIR}/tests/support/catch.h")
      target_compile_options(feder_pch_test PRIVATE ${feder_test_flags})
    else()
      add_library(feder_pch_library STATIC ${PROJECT_BINARY_DIR}/pch/library.cpp)
      target_link_libraries(feder_pch_library PRIVATE feder_flags)
      target_precompile_headers(feder_pch_library PRIVATE ${feder_pch_standard})
      # as the libraries that take it: clang refuses another visibility
      set_target_properties(feder_pch_library PROPERTIES CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
    endif()
  endif()
  target_precompile_headers(${target} REUSE_FROM feder_pch_${kind})
  if(kind STREQUAL "test")
    target_compile_options(${target} PRIVATE ${feder_test_flags})
  endif()
  # gcc 12 warns inside its own headers when they come precompiled (its bug 105651 again)
  target_compile_options(${target} PRIVATE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>)
endfunction()
