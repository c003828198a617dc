# Installs a build to a temporary prefix, builds tests/embed against it with find_package(feder) and runs it.
#   cmake -DBUILD=<build folder> -DSOURCE=<this folder> -DCOMPILER=<c++> -DTYPE=<build type> -DFLAGS=<flags> -P
#   run.cmake
set(work ${BUILD}/embed)
file(REMOVE_RECURSE ${work}/prefix ${work}/build)

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what} failed (${status}):\n${output}\n${errors}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect text pattern)
  if(NOT text MATCHES "${pattern}")
    message(FATAL_ERROR "expected '${pattern}' in:\n${text}")
  endif()
endfunction()

run("install" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/prefix)
# what is installed to be included: the public headers, and no folder of the house
file(GLOB_RECURSE installed RELATIVE ${work}/prefix/include ${work}/prefix/include/*)
foreach(file ${installed})
  if(NOT file MATCHES "^feder/[a-z]+\\.h$")
    message(FATAL_ERROR "${file} is installed and no public header")
  endif()
endforeach()
list(LENGTH installed headers)
if(headers GREATER 30)
  message(FATAL_ERROR "${headers} public headers: ${installed}")
endif()
run("configure" ${CMAKE_COMMAND} -S ${SOURCE} -B ${work}/build -G Ninja -DCMAKE_PREFIX_PATH=${work}/prefix -DFEDER_PREFIX=${work}/prefix
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_BUILD_TYPE=${TYPE} "-DCMAKE_CXX_FLAGS=${FLAGS}"
    -DCMAKE_CXX_FLAGS_RELEASE=-O1\ -DNDEBUG  # what the hosts do themselves is little
    -DCMAKE_FIND_PACKAGE_NO_PACKAGE_REGISTRY=ON)
run("build" ${CMAKE_COMMAND} --build ${work}/build)

run("embed" ${work}/build/embed)
expect("${output}" "body \"(floor|ball)\" meets body \"(floor|ball)\"")
expect("${output}" "1.000 s: hash [0-9a-f]+")
run("lean" ${work}/build/lean)
expect("${output}" "lean: 2 systems")
run("whole" ${work}/build/whole)
expect("${output}" "world: [0-9]+ systems.*study: 3 points.*whole: (float|double)")

# the same motion from a host that has nets alone as from the program
set(share ${work}/prefix/share/feder)
set(scene ${share}/scenes/springs/pendulum.lua)
run("springs_host" ${work}/build/springs_host ${scene} ${share}/scripts 60)
string(REGEX MATCH "\"hash\": \"[0-9a-f]+\"" hash "${output}")
run("pendulum" ${work}/prefix/bin/feder run ${scene} --seconds 0.25 --json)
expect("${output}" "\"steps\": 60[^0-9]")
if(NOT hash OR NOT output MATCHES "${hash}")
  message(FATAL_ERROR "springs_host: ${hash}, feder: ${output}")
endif()

# what a host does not list is not in its program
find_program(NM nm)
if(NM)
  run("nm" ${NM} -C ${work}/build/lean)
  expect("${output}" "feder::Rigid::")
  if(output MATCHES "feder::Springs|luaL?_|yaml")
    message(FATAL_ERROR "the lean program contains '${CMAKE_MATCH_0}', which it does not use")
  endif()
  run("nm" ${NM} -C ${work}/build/springs_host)
  expect("${output}" "feder::Springs::")
  if(output MATCHES "feder::(Rigid|Collide|Cloth|Fluid)::|YAML::")
    message(FATAL_ERROR "the host of nets contains '${CMAKE_MATCH_0}', which it does not use")
  endif()
endif()

# the installed program finds its scripts and scenes
run("installed feder" ${work}/prefix/bin/feder run ${work}/prefix/share/feder/scenes/rigid/tower.lua --seconds 0.1 --json)
expect("${output}" "\"hash\": \"[0-9a-f]+\"")
