# Benchmarks: programs that print JSON, never tests.
if(PATHFIT_BENCH)
  find_package(nlohmann_json 3 REQUIRED)
  add_executable(render_bench ${CMAKE_CURRENT_LIST_DIR}/render_bench.cpp ${CMAKE_CURRENT_LIST_DIR}/bench_scenes.cpp)
  target_link_libraries(render_bench PRIVATE pathfit_optim pathfit_test_support nlohmann_json::nlohmann_json)
  add_executable(gradient_bench
    ${CMAKE_CURRENT_LIST_DIR}/gradient_bench.cpp
    ${CMAKE_CURRENT_LIST_DIR}/gradient_options.cpp
    ${CMAKE_CURRENT_LIST_DIR}/peer_scenes.cpp
    ${CMAKE_CURRENT_LIST_DIR}/repeated_images.cpp)
  target_link_libraries(gradient_bench PRIVATE pathfit_optim nlohmann_json::nlohmann_json)
  add_executable(scene_bench ${CMAKE_CURRENT_LIST_DIR}/scene_bench.cpp)
  target_link_libraries(scene_bench PRIVATE pathfit_test_support nlohmann_json::nlohmann_json)
  add_executable(surface_distance ${CMAKE_CURRENT_LIST_DIR}/surface_distance.cpp)
  target_link_libraries(surface_distance PRIVATE pathfit_renderer nlohmann_json::nlohmann_json)
endif()
