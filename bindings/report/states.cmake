# What other programs read of objects (states.h), and VTK files of it.
feder_module(states ROOT ${PROJECT_SOURCE_DIR}/bindings SOURCES states.cpp vtk.cpp NEEDS world report)
foreach(system rigid springs cloth rope soft fluid)
  if(TARGET feder_states AND TARGET feder_${system})
    feder_variant(states ${system} FILE states_${system}.cpp)
    target_link_libraries(feder_states PRIVATE feder_${system})
  endif()
endforeach()
