# feder view: the window and its panels. Left out, with a message, where GLFW or Dear ImGui are missing.
feder_left_out(left_out window)
if(left_out OR NOT TARGET feder_live)
  return()
endif()
pkg_check_modules(FEDER_GLFW QUIET IMPORTED_TARGET glfw3)
pkg_check_modules(FEDER_PANELS QUIET IMPORTED_TARGET imgui)
if(NOT TARGET feder_view OR NOT TARGET feder_report OR NOT FEDER_GLFW_FOUND OR NOT FEDER_PANELS_FOUND)
  message(STATUS "feder: no command 'view': it needs the module 'view', libglfw3-dev and libimgui-dev")
  return()
endif()
feder_module(window ROOT ${PROJECT_SOURCE_DIR}/bindings
  SOURCES viewer.cpp viewer_input.cpp window.cpp theme.cpp panel_layout.cpp status.cpp sampler.cpp scene_list.cpp
          panel_transport.cpp panel_scene.cpp panel_inspector.cpp panel_watch.cpp panel_console.cpp panel_overlay.cpp
  NEEDS live view report)
feder_view_files(window panel)
target_link_libraries(feder_window PRIVATE PkgConfig::FEDER_GLFW PkgConfig::FEDER_PANELS)
