# Writes the short commit of SOURCE as a C++ string to OUT, only when it changed. Empty for a tree that is no checkout,
# also where it lies within another one.
execute_process(COMMAND git -C ${SOURCE} rev-parse --show-prefix --short HEAD OUTPUT_VARIABLE lines ERROR_QUIET)
string(REGEX MATCH "^\n([0-9a-f]+)\n$" found "${lines}")
set(text "\"${CMAKE_MATCH_1}\"\n")
if(EXISTS ${OUT})
  file(READ ${OUT} before)
endif()
if(NOT "${before}" STREQUAL "${text}")
  file(WRITE ${OUT} "${text}")
endif()
