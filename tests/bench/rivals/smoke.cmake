# The programs of scripts/compare against the installed package, on small scenes: they build, and print what holds.
#   cmake -DBUILD=<build folder> -DSOURCE=<this folder> -DCOMPILER=<c++> -P smoke.cmake
cmake_minimum_required(VERSION 3.23)
set(work ${BUILD}/rivals)
file(REMOVE_RECURSE ${work})

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE errors)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what} failed (${status}):\n${output}\n${errors}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# The number of that name in the program's line lies within the bounds.
function(expect name least most)
  string(JSON value GET "${output}" ${name})
  if(NOT value GREATER_EQUAL least OR NOT value LESS_EQUAL most)
    message(FATAL_ERROR "${name} is not within ${least} .. ${most}:\n${output}")
  endif()
endfunction()

run("install" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/prefix)
run("configure" ${CMAKE_COMMAND} -S ${SOURCE} -B ${work}/programs -G Ninja -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER=${COMPILER} -DFEDER_PREFIX=${work}/prefix -DCMAKE_FIND_PACKAGE_NO_PACKAGE_REGISTRY=ON)
run("build" ${CMAKE_COMMAND} --build ${work}/programs)
run("end states" ${work}/programs/rival_check)

# feder, and Bullet where it is installed
file(STRINGS ${work}/programs/engines.txt engines)
if(NOT "feder" IN_LIST engines)
  message(FATAL_ERROR "no feder among the engines: ${engines}")
endif()
foreach(engine ${engines})
  run("${engine}: columns" ${work}/programs/rival_${engine} columns 30 1)
  expect(steps 30 30)
  expect(bodies 500 500)
  expect(processor_ms 0.001 1000)
  expect(memory_mb 0.1 100)
  expect(sink_m 0.001 0.1)
  expect(overlap_m 0.0001 0.05)
  expect(moved 0 0)
  expect(lost 0 0)
  run("${engine}: heavy_chains" ${work}/programs/rival_${engine} heavy_chains 30 1)
  expect(joints 400 400)
  expect(joint_error_m 0 0.5)
  expect(sink_m 0.5 3)
  # drum, compound and sleep; hulls and a mesh
  run("${engine}: washer" ${work}/programs/rival_${engine} washer 3 1)
  expect(bodies 8000 8000)
  run("${engine}: convex_vs_mesh" ${work}/programs/rival_${engine} convex_vs_mesh 3 1)
  expect(bodies 1764 1764)
endforeach()

# sheets of cloth: threads may be stretched, and not without end
file(STRINGS ${work}/programs/sheets.txt sheets)
foreach(engine ${sheets})
  run("${engine}: a sheet" ${work}/programs/sheet_${engine} 20 1 0.5 4 4 1)
  expect(side_vertices 20 20)
  expect(frame_ms 0.001 1000)
  expect(row_ns 0.1 1000)
  expect(sweeps 16 64)
  expect(worst 0.0001 0.5)
endforeach()
