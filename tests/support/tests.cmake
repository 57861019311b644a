# What several tests share; linked, not run.
find_package(draco REQUIRED CONFIG)
find_package(meshoptimizer REQUIRED CONFIG)
find_package(nlohmann_json 3 REQUIRED)
add_library(pathfit_test_support STATIC
  ${CMAKE_CURRENT_LIST_DIR}/test_scenes.cpp ${CMAKE_CURRENT_LIST_DIR}/compressed_gltf.cpp)
target_link_libraries(pathfit_test_support
  PUBLIC pathfit_renderer PRIVATE draco::draco meshoptimizer::meshoptimizer nlohmann_json::nlohmann_json)
