# What the viewer does that needs no window: the running scene, its past, reloading, picking.
feder_module(live ROOT ${PROJECT_SOURCE_DIR}/bindings
  SOURCES live_scene.cpp scene_run.cpp history.cpp file_watch.cpp picking.cpp
  NEEDS lua)
feder_view_files(live picking)
